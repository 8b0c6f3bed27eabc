"""Where the results of `halo evaluate` go: the terminal, a CSV file, a page."""

from __future__ import annotations

import os
import platform
import shlex
import subprocess
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from datetime import date
from importlib.metadata import version
from pathlib import Path

from halo_service.app.files import STDOUT, written
from halo_service.app.tables import print_tables
from halo_service.errors import UserError
from halo_service.evaluation.metrics.result import Result
from halo_service.evaluation.report import csv_file
from halo_service.evaluation.report.page import page
from halo_service.evaluation.report.summary import brief, heading, results_file, tables

PAGE = "index.html"


@dataclass(frozen=True, slots=True)
class ReportOptions:
    """What to print and write."""

    csv: str | None = None
    """File for every figure; `-`: on stdout instead of the tables."""
    each: bool = False
    """Print one line per user, task and method instead of the tables."""
    markdown: bool = False
    """Print a page for `docs/results` instead of the tables."""
    report: Path | None = None
    """A folder for a page with the plots."""


@contextmanager
def open_report(options: ReportOptions) -> Iterator[Callable[[Sequence[Result]], None]]:
    """Open all files before hours of work, and yield what writes the results.

    Raises `UserError` for a file that cannot be written; the files appear when all went well.
    """
    package = version("halo-service")
    with ExitStack() as stack:
        figures = stack.enter_context(written(options.csv)) if options.csv is not None else None
        shown = stack.enter_context(written(str(_page(options.report)))) if options.report else None

        def write(results: Sequence[Result]) -> None:
            if figures is not None:
                csv_file.write(results, package, figures)
            if shown is not None:
                shown.write(page(results, _facts(results, package)))
            if options.csv != STDOUT:
                _print(options, results, package)

        yield write


def _page(folder: Path) -> Path:
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise UserError(
            f"the folder {folder} cannot be created ({error.strerror}); give --report another one"
        ) from error
    return folder / PAGE


def _print(options: ReportOptions, results: Sequence[Result], package: str) -> None:
    if options.each:
        print("\n".join(brief(results)))
    elif options.markdown:
        print(results_file(results, _facts(results, package)), end="")
    else:
        print("\n".join(heading(results, package)))
        print()
        print_tables(*tables(results))


def _facts(results: Sequence[Result], package: str) -> dict[str, str]:
    """Return the facts that identify the results."""
    return {
        "date": date.today().isoformat(),
        "command": shlex.join(("halo", *sys.argv[1:])),
        "commit": _commit(),
        "machine": f"{platform.system()} on {platform.machine()}, {os.cpu_count()} cores",
        "what": "; ".join(heading(results, package)),
    }


def _commit() -> str:
    """Return the commit of the checkout that runs; `unknown` outside one."""
    command = ["git", "describe", "--always", "--dirty", "--abbrev=10"]
    try:
        run = subprocess.run(
            command, cwd=Path(__file__).parent, capture_output=True, text=True, check=True
        )
    except (OSError, subprocess.CalledProcessError):
        return "unknown"
    return run.stdout.strip()
