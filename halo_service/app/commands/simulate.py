"""`halo simulate`: render a recording of the virtual camera."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from halo_service.app.options import add_debug
from halo_service.errors import UserError

SUMMARY = "render a recording of the virtual camera, with its ground truth"
EXAMPLE = "halo simulate drumming,seed=3,material=foam --out drumming.mkv --truth drumming.jsonl"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of the command."""
    add_debug(parser)
    parser.add_argument(
        "scenario", nargs="?", metavar="SCENARIO", help="e.g. drumming,seed=3,material=foam"
    )
    parser.add_argument("--out", type=Path, metavar="X.mkv", help="the recording")
    parser.add_argument("--truth", metavar="X.jsonl", help="ground truth, a line a frame")
    parser.add_argument("--script", metavar="X.json", help="the calibration steps in it, by time")
    parser.add_argument("--seed", type=int, metavar="N", help="a seed is one user at one place")
    parser.add_argument(
        "--seconds", type=float, metavar="S", help="length, for a scenario without an end"
    )
    parser.add_argument(
        "--canvas-truth", metavar="X.jsonl", help="ground truth of an installation, on its canvas"
    )
    parser.add_argument(
        "--start",
        type=float,
        default=0.0,
        metavar="S",
        help="when that truth begins: 0, or a Unix time, for live services (default: 0)",
    )
    parser.add_argument(
        "--layout", metavar="X.toml", help="layout of an installation's canvas; nodes camera-1, ..."
    )
    parser.add_argument("--force", action="store_true", help="replace a layout file of that name")
    parser.add_argument("--no-colour", action="store_true", help="record no colour")
    parser.add_argument(
        "--gallery", type=Path, metavar="X.png", help="draw all materials and states in one picture"
    )


def run(options: argparse.Namespace) -> int:
    """Render the recording, the gallery, or both; write what belongs to an installation."""
    from halo_service.app.files import STDOUT
    from halo_service.app.recordings.simulate import (
        InstallationRequest,
        SimulateRequest,
        simulate,
        write_installation,
    )

    if options.gallery is not None:
        from halo_service.virtual.gallery import save

        save(options.gallery, 1 if options.seed is None else options.seed)
        print(f"halo: the gallery is in {options.gallery}", file=sys.stderr)
    elif options.scenario is None or not _files(options):
        raise UserError("simulate needs a SCENARIO and --out X.mkv, or --gallery X.png")
    if options.scenario is not None and (options.layout or options.canvas_truth):
        write_installation(
            InstallationRequest(
                options.scenario,
                options.seed,
                options.layout,
                options.canvas_truth,
                options.start,
                options.seconds,
                options.force,
            )
        )
        if options.layout not in (None, STDOUT):
            print(f"next: halo canvas serve {options.layout}", file=sys.stderr)
    if options.scenario is not None and options.out is not None:
        request = SimulateRequest(
            options.scenario,
            options.out,
            options.truth,
            options.script,
            options.seed,
            options.seconds,
            not options.no_colour,
        )
        print(f"halo: {simulate(request)} frames in {options.out}", file=sys.stderr)
        if options.truth is None:
            print("halo: no ground truth; --truth X.jsonl writes it too", file=sys.stderr)
        print(f"next: halo serve --source recording:{options.out}", file=sys.stderr)
    return 0


def _files(options: argparse.Namespace) -> bool:
    """Whether there is a file to write."""
    return bool(options.out or options.layout or options.canvas_truth)
