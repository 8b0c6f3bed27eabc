"""`halo record`: record any source."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from halo_service.app.options import add_config, add_source, settings_from

SUMMARY = "record a camera into a file"
EXAMPLE = "halo record desk.mkv --seconds 30"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of the command."""
    add_config(parser)
    parser.add_argument("out", type=Path, metavar="OUT.mkv")
    add_source(parser)
    parser.add_argument("--seconds", type=float, metavar="S", help="length (default: until Ctrl-C)")
    parser.add_argument("--no-colour", action="store_true", help="record no colour, for privacy")


def run(options: argparse.Namespace) -> int:
    """Record until the source ends, the time is over, or Ctrl-C."""
    from halo_service.app.recordings.record import record

    source = settings_from(options).source
    count = record(options.out, source, options.seconds, not options.no_colour)
    print(f"halo: {count} frames in {options.out}", file=sys.stderr)
    print(f"next: halo serve --source recording:{options.out} --profile desk", file=sys.stderr)
    return 0
