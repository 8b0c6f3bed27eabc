"""Held levels and small lifts: drawings, one panel per family of halo curves.

Rule: each function returns the drawings of one figure, none where the results hold none.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from halo_service.evaluation.metrics.levels import Trial
from halo_service.evaluation.metrics.result import Result
from halo_service.evaluation.metrics.retaps import reported_by_lift
from halo_service.evaluation.report import select
from halo_service.evaluation.report.select import Choice
from halo_service.evaluation.report.svg import Panel, axes, coloured, dots, drawing, line, ticks

LEVELS = {
    "hover": ("mm", 20.0, (0, 5, 10, 15, 20)),
    "pressure": ("g", 450.0, (0, 100, 200, 300, 400)),
}
"""Unit, where the scales end, and their numbers."""


def levels(results: Sequence[Result], kind: str, against: str = "true") -> list[str]:
    """Reported over true levels, one drawing per family of halo curves.

    `against`: what the levels are, for the axis; e.g. "requested" where the truth is unknown.
    """
    drawings = []
    for family in sorted({r.subject.family for r in results}):
        mine = [r for r in results if r.subject.family == family]
        if any(trial.kind == kind for trial in select.pooled(mine).trials):
            drawings.append(_family(family, mine, kind, against))
    return drawings


def retaps(results: Sequence[Result]) -> list[str]:
    """Share of reported re-taps, over how far the finger rose between."""
    panel = Panel(420.0, 170.0, (0.0, 6.5), (0.0, 105.0))
    lines = []
    for method in select.methods(results):
        shares = reported_by_lift(select.pooled(select.of(results, method)).retaps)
        percents = [100.0 * share for share in shares.values()]
        if shares:
            lines.append(line(panel, shares, percents, coloured(method)))
            lines.append(dots(panel, shares, percents, coloured(method)))
    if not lines:
        return []
    frame = axes(
        panel,
        "",
        "lift between two taps, mm",
        "reported, %",
        ticks(*range(7)),
        ticks(0, 25, 50, 75, 99),
    )
    return [drawing(panel, "re-taps reported by lift", [frame, *lines])]


def _family(family: str, results: Sequence[Result], kind: str, against: str) -> str:
    unit, end, numbers = LEVELS[kind]
    panel = Panel(230.0, 230.0, (0.0, end), (0.0, end))
    names = f"{against}, {unit}", f"reported, {unit}"
    parts = [
        axes(panel, family, *names, ticks(*numbers), ticks(*numbers)),
        line(panel, (0.0, end), (0.0, end), "truth"),
    ]
    for method in reversed(select.methods(results)):  # the first is drawn on top
        mine = select.of(results, method)
        for choice, style in ((select.plain_noise, "plain"), (select.doubled_noise, "noisy")):
            held = _held(mine, choice, kind)
            parts.append(_mean_line(panel, held, f"{style} {coloured(method)}"))
    for method in select.methods(results)[:1]:
        held = _held(select.of(results, method), select.plain_noise, kind)
        levels, reported = [t.level for t in held], [t.reported for t in held]
        parts.append(dots(panel, levels, reported, coloured(method)))
    return drawing(panel, f"{kind} with {family} curves", parts)


def _held(results: Sequence[Result], choice: Choice, kind: str) -> list[Trial]:
    """Return the trials with a reading."""
    trials = select.pooled(results, choice).trials
    return [trial for trial in trials if trial.kind == kind and not np.isnan(trial.reported)]


def _mean_line(panel: Panel, held: Sequence[Trial], kind: str) -> str:
    means = {
        level: float(np.mean([trial.reported for trial in held if trial.level == level]))
        for level in sorted({trial.level for trial in held})
    }
    return line(panel, means, means.values(), kind)
