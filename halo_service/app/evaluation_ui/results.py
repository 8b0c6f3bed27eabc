"""Where the results of `halo evaluate` go: the terminal, a file of figures, a page."""

from __future__ import annotations

import os
import platform
import shlex
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from datetime import date
from importlib.metadata import version
from pathlib import Path

from halo_service.app.files import STDOUT, written
from halo_service.errors import UserError
from halo_service.evaluation.metrics.result import Result
from halo_service.evaluation.report import csv_rows as rows
from halo_service.evaluation.report.brief import brief
from halo_service.evaluation.report.page import page
from halo_service.evaluation.report.summary import heading, told
from halo_service.evaluation.report.table import as_markdown, as_text

PAGE = "index.html"


@dataclass(frozen=True, slots=True)
class Telling:
    """How results are told."""

    csv: str | None = None
    """Every figure into this file; `-`: instead of the tables."""
    each: bool = False
    """A line a person, task and method instead of the tables."""
    markdown: bool = False
    report: Path | None = None
    """A folder for a page with the plots."""


@contextmanager
def telling(asked: Telling) -> Iterator[Callable[[Sequence[Result]], None]]:
    """Open what is to be written, before hours of work, and give what tells the results.

    Raises `UserError` for what cannot be written; the files appear when all went well.
    """
    package = version("halo-service")
    with ExitStack() as stack:
        figures = stack.enter_context(written(asked.csv)) if asked.csv is not None else None
        shown = stack.enter_context(written(str(_page(asked.report)))) if asked.report else None

        def tell(results: Sequence[Result]) -> None:
            if figures is not None:
                rows.write(results, package, figures)
            if shown is not None:
                shown.write(page(results, _facts(results, package)))
            if asked.csv != STDOUT:
                print(_words(asked, results, package))

        yield tell


def _page(folder: Path) -> Path:
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise UserError(
            f"the folder {folder} cannot be made ({error.strerror}); give --report another one"
        ) from error
    return folder / PAGE


def _words(asked: Telling, results: Sequence[Result], package: str) -> str:
    if asked.each:
        return "\n".join(brief(results))
    return "\n\n".join(told(results, package, as_markdown if asked.markdown else as_text))


def _facts(results: Sequence[Result], package: str) -> dict[str, str]:
    """Say what a page is of."""
    return {
        "command": shlex.join(("halo", *sys.argv[1:])),
        "date": date.today().isoformat(),
        "machine": f"{platform.system()} on {platform.machine()}, {os.cpu_count()} cores",
        "what": "; ".join(heading(results, package)),
    }
