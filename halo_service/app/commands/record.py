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
    parser.add_argument("out", type=Path, metavar="OUT.mkv", help="file to write")
    add_source(parser)
    parser.add_argument("--seconds", type=float, metavar="S", help="length (default: until Ctrl-C)")
    parser.add_argument(
        "--no-colour",
        action="store_true",
        help="record no colour, for privacy: 15 MB a second instead of 22",
    )
    parser.add_argument(
        "--area",
        metavar="P",
        help="record only the surface of this profile and 80 mm around it, without colour: "
        "6 MB a second for 300 x 200 mm seen from half a metre",
    )
    parser.add_argument("--force", action="store_true", help="replace a file of that name")


def run(options: argparse.Namespace) -> int:
    """Record until the source ends, the time is over, or Ctrl-C.

    Exit code 1: the file is complete, but frames were lost.
    """
    from halo_service.app.recordings.record import record
    from halo_service.profile.store import load, profile_path

    source = settings_from(options).source
    area = load(profile_path(options.area)) if options.area else None
    colour = not options.no_colour
    done = record(options.out, source, options.seconds, colour, options.force, area)
    size_mb = options.out.stat().st_size / 1e6
    print(f"halo: {done.frames} frames in {options.out}, {size_mb:.0f} MB", file=sys.stderr)
    if done.ended:
        print(f"halo: it ended early: {done.ended}", file=sys.stderr)
    if done.lost + done.bad:
        count = done.frames + done.lost + done.bad
        print(
            f"halo: {done.lost} of {count} frames were lost and {done.bad} were bad"
            + ("" if done.complete else "; close other programs, or use a faster machine"),
            file=sys.stderr,
        )
    print(f"next: halo serve --source recording:{options.out} --profile desk", file=sys.stderr)
    return 0 if done.complete else 1
