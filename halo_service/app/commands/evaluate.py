"""`halo evaluate`: measure how good the sensing is."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from halo_service.app.files import STDOUT
from halo_service.app.options import add_profile, add_source, settings_from
from halo_service.errors import UserError

if TYPE_CHECKING:
    from halo_service.evaluation.metrics.result import Result

SUMMARY = "measure the sensing: on virtual users, a recording or a real table"
EXAMPLE = "halo evaluate --quick"

STUDY = (
    "quick", "users", "materials", "tasks", "labels", "cache", "cached_only", "jobs", "sensor",
    "heights", "modes",
)  # fmt: skip
"""Options of the study alone."""
LIVE = ("source", "no_colour")
"""Options of a session on a real table alone."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of the command."""
    add_profile(parser)
    parser.add_argument(
        "recording", nargs="?", type=Path, metavar="RECORDING", help="evaluate this recording"
    )
    parser.add_argument("--truth", type=Path, metavar="T.jsonl", help="its ground truth")
    parser.add_argument(
        "--script", type=Path, metavar="S.json", help="what the user had to do in it, by time"
    )
    parser.add_argument("--live", type=Path, metavar="DIR", help="guided session on a real table")
    add_source(parser, "with --live: as for serve")
    parser.add_argument("--no-colour", action="store_true", help="with --live: record no colour")
    parser.add_argument("--quick", action="store_true", help="a small part of the study, 5 minutes")
    parser.add_argument("--method", type=_names, default=(), metavar="M,...", help="ours,paper,...")
    parser.add_argument("--users", type=_numbers, default=(), metavar="N,...", help="their seeds")
    parser.add_argument("--materials", type=_names, default=(), metavar="M,...", help="paper,...")
    parser.add_argument(
        "--sensor", choices=("true", "kind"), help="of the virtual camera (quick: kind, else true)"
    )
    parser.add_argument(
        "--heights",
        type=_heights,
        default=(),
        metavar="MM,...",
        help="camera heights: all for each user",
    )
    parser.add_argument(
        "--modes", type=_names, default=(), metavar="M,...", help="depth modes: all for each user"
    )
    parser.add_argument("--tasks", type=_names, default=(), metavar="T,...", help="pointing,...")
    parser.add_argument("--labels", type=Path, metavar="DIR", help="touches of real people")
    parser.add_argument("--cache", type=Path, metavar="DIR", help="folder for simulated recordings")
    parser.add_argument(
        "--cached-only", action="store_true", help="simulate nothing: use only cached recordings"
    )
    parser.add_argument(
        "--jobs", type=_count, metavar="N", help="number of processes (default: one a core)"
    )
    parser.add_argument("--each", action="store_true", help="a line a user, task and method")
    parser.add_argument(
        "--markdown",
        action="store_true",
        help="print a page for docs/results",
    )
    parser.add_argument("--report", type=Path, metavar="DIR", help="write a web page with plots")
    parser.add_argument("--csv", metavar="FILE", help="write every figure; - for stdout")


def run(options: argparse.Namespace) -> int:
    """Run the study, or evaluate a recording, and print the results."""
    from halo_service.app.evaluation_ui.evaluate import known_methods
    from halo_service.app.evaluation_ui.results import ReportOptions, open_report

    check_combination(options)
    known_methods(options.method)  # before the four minutes of --live
    report = ReportOptions(options.csv, options.each, options.markdown, options.report)
    with open_report(report) as write:
        write(_results(options))
    return 0


def _results(options: argparse.Namespace) -> Sequence[Result]:
    from halo_service.app.evaluation_ui import evaluate
    from halo_service.app.evaluation_ui.guided import run_session

    settings = settings_from(options)
    if options.live is not None:
        recording, script = run_session(settings, options.live, not options.no_colour)
        recorded = evaluate.RecordingOptions(recording, None, script, options.method)
        return evaluate.evaluate_recording(settings, recorded)
    if options.recording is not None:
        recorded = evaluate.RecordingOptions(
            options.recording, options.truth, options.script, options.method
        )
        return evaluate.evaluate_recording(settings, recorded)
    study = evaluate.StudyOptions(
        options.quick,
        options.method,
        options.users,
        options.materials,
        options.tasks,
        options.labels,
        options.cache,
        options.cached_only,
        options.jobs,
        options.sensor,
        options.heights,
        options.modes,
    )
    return evaluate.evaluate(settings, study, _confirm)


def _confirm(hours: float) -> bool:
    """Ask on a terminal whether to run for so long; a script is not asked."""
    if not (sys.stdin.isatty() and sys.stderr.isatty()):
        return True
    print(f"This takes about {hours:.1f} hours on this machine. Run it? [y/N] ", file=sys.stderr)
    return input().strip().lower() in ("y", "yes")


def check_combination(options: argparse.Namespace) -> None:
    """Raise `UserError` for an option that has no effect with the others."""
    if options.live is not None:
        _refuse(options, "--live", "recording", "truth", "script", *STUDY)
    elif options.recording is not None:
        _refuse(options, "RECORDING", *LIVE, *STUDY)
    else:
        study = "without RECORDING or --live runs the study, which"
        _refuse(options, study, "truth", "script", "profile", *LIVE)
    if options.cached_only:
        _refuse(options, "--cached-only", "quick", "labels")
    if options.quick:
        _refuse(options, "--quick", "labels")
    if options.csv == STDOUT:
        _refuse(options, "--csv -", "each", "markdown")
    if options.each:
        _refuse(options, "--each", "markdown")


def _refuse(options: argparse.Namespace, with_what: str, *idle: str) -> None:
    given = [_flag(name) for name in idle if getattr(options, name)]
    if given:
        flags = ", ".join(given)
        raise UserError(f"evaluate {with_what} does not use {flags}: leave {flags} out")


def _flag(name: str) -> str:
    return "RECORDING" if name == "recording" else f"--{name.replace('_', '-')}"


def _names(text: str) -> tuple[str, ...]:
    return tuple(part for part in text.split(",") if part)


def _numbers(text: str) -> tuple[int, ...]:
    if not all(part.isdecimal() for part in _names(text)):
        raise argparse.ArgumentTypeError(f"{text!r} must be whole numbers with commas between")
    return tuple(int(part) for part in _names(text))


def _heights(text: str) -> tuple[float, ...]:
    return tuple(float(mm) for mm in _numbers(text))


def _count(text: str) -> int:
    if not text.isdecimal() or int(text) < 1:
        raise argparse.ArgumentTypeError(f"{text!r} must be a whole number, 1 or more")
    return int(text)
