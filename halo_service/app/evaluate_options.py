"""What `halo evaluate` can be told on the command line. Nothing heavy is imported to read it."""

from __future__ import annotations

import argparse
from pathlib import Path

from halo_service.app import verbs
from halo_service.app.files import STDOUT
from halo_service.errors import UserError

STUDY = ("quick", "users", "materials", "tasks", "labels", "keep", "kept_only", "jobs")
"""What only the study listens to."""
LIVE = ("source", "no_colour")
"""What only a session on a real table listens to."""


def add_to(verb: argparse.ArgumentParser) -> None:
    """Give the verb its options."""
    verb.add_argument("recording", nargs="?", type=Path, metavar="RECORDING", help="judge this one")
    verb.add_argument("--truth", type=Path, metavar="T.jsonl", help="what was true of it")
    verb.add_argument("--script", type=Path, metavar="S.json", help="what was asked for in it")
    verb.add_argument("--live", type=Path, metavar="DIR", help="be guided on a real table")
    verb.add_argument("--source", metavar="S", help="with --live: as for serve")
    verb.add_argument("--no-colour", action="store_true", help="with --live: leave colour out")
    verb.add_argument("--quick", action="store_true", help="a small part of it, in 5 minutes")
    verb.add_argument("--method", type=_names, default=(), metavar="M,...", help="ours,paper,...")
    verb.add_argument("--users", type=_numbers, default=(), metavar="N,...", help="their seeds")
    verb.add_argument("--materials", type=_names, default=(), metavar="M,...", help="paper,...")
    verb.add_argument("--tasks", type=_names, default=(), metavar="T,...", help="pointing,...")
    verb.add_argument("--labels", type=Path, metavar="DIR", help="real people's touches to play")
    verb.add_argument("--keep", type=Path, metavar="DIR", help="where takes are kept")
    verb.add_argument("--kept-only", action="store_true", help="draw nothing: what is kept there")
    verb.add_argument("--jobs", type=_count, metavar="N", help="processes (default: the cores)")
    verb.add_argument("--each", action="store_true", help="a line a person, task and method")
    verb.add_argument("--markdown", action="store_true", help="tables for a page")
    verb.add_argument("--report", type=Path, metavar="DIR", help="a page with the plots")
    verb.add_argument("--csv", metavar="FILE", help="every figure of every person; - for stdout")
    verb.set_defaults(run=verbs.evaluate)


def refuse_idle(options: argparse.Namespace) -> None:
    """Raise `UserError` for an option that what is asked for would not listen to."""
    if options.live is not None:
        _refuse(options, "--live", "recording", "truth", "script", *STUDY)
    elif options.recording is not None:
        _refuse(options, "RECORDING", *LIVE, *STUDY)
    else:
        study = "without RECORDING or --live plays the study, which"
        _refuse(options, study, "truth", "script", "profile", *LIVE)
    if options.kept_only:
        _refuse(options, "--kept-only", "quick", "labels")
    if options.quick:
        _refuse(options, "--quick", "labels")
    if options.csv == STDOUT:
        _refuse(options, "--csv -", "each", "markdown")
    if options.each:
        _refuse(options, "--each", "markdown")


def _refuse(options: argparse.Namespace, asked: str, *idle: str) -> None:
    given = [_flag(name) for name in idle if getattr(options, name)]
    if given:
        flags = ", ".join(given)
        raise UserError(f"evaluate {asked} has no use for {flags}: leave {flags} out")


def _flag(name: str) -> str:
    return "RECORDING" if name == "recording" else f"--{name.replace('_', '-')}"


def _names(text: str) -> tuple[str, ...]:
    return tuple(part for part in text.split(",") if part)


def _numbers(text: str) -> tuple[int, ...]:
    if not all(part.isdecimal() for part in _names(text)):
        raise argparse.ArgumentTypeError(f"{text!r} must be whole numbers with commas between")
    return tuple(int(part) for part in _names(text))


def _count(text: str) -> int:
    if not text.isdecimal() or int(text) < 1:
        raise argparse.ArgumentTypeError(f"{text!r} must be a whole number from 1 up")
    return int(text)
