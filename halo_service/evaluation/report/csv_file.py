"""Results as CSV: one row per user, task, method and figure."""

from __future__ import annotations

import csv
from collections.abc import Iterator, Sequence
from typing import TextIO

import numpy as np

from halo_service.evaluation.metrics.result import Result
from halo_service.evaluation.report.figures import figures

COLUMNS = (
    "seed", "subject", "material", "family", "task", "method", "figure", "value", "note",
    "profile", "settings", "version",
)  # fmt: skip
DIGITS = 4
"""Decimals: a tenth of a micrometre, far below what anything here measures."""


def write(results: Sequence[Result], version: str, out: TextIO) -> None:
    """Write all rows with a head. `version`: of the package."""
    table = csv.writer(out, lineterminator="\n")
    table.writerow(COLUMNS)
    for each in results:
        who = each.subject
        head = ("" if who.seed is None else who.seed, who.name, who.material, who.family)
        tail = (each.profile, each.settings, version)
        for name, value, note in _rows(each):
            table.writerow((*head, each.task, each.method, name, value, note, *tail))


def _rows(result: Result) -> Iterator[tuple[str, str, str]]:
    """Yield figure, value and note of one result."""
    if result.scores is None:
        yield "calibrated", "0", result.refused
        return
    yield "calibrated", "1", ""
    for name, value in figures(result.scores):
        if np.isfinite(value):
            yield name, f"{round(value, DIGITS):g}" if value % 1 else f"{value:.0f}", ""
