"""`halo calibrate`: make the profile of a place and a finger."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from halo_service.app.options import add_profile, add_screen, add_source, settings_from

if TYPE_CHECKING:
    from halo_service.app.calibration_ui.place import PlaceRequest

SUMMARY = "calibrate a table and a finger, step by step"
EXAMPLE = "halo calibrate --profile desk"

STEPS = ("camera", "background", "surface", "touch", "sweep", "projector", "anchor", "pilot")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of the command."""
    add_profile(parser)
    parser.add_argument(
        "step",
        nargs="?",
        choices=STEPS,
        metavar="STEP",
        help="camera, background, surface, touch, sweep, projector, anchor or pilot "
        "(default: each of background, touch, "
        "sweep that is missing)",
    )
    add_source(parser)
    parser.add_argument("--script", type=Path, metavar="FILE", help="steps of a recording, by time")
    parser.add_argument("--hover-mm", type=float, metavar="MM", help="height of the hover spacer")
    parser.add_argument("--subtle-mm", type=float, metavar="MM", help="height of the subtle spacer")
    parser.add_argument("--touch-g", type=float, metavar="G", help="force of the relaxed touch")
    parser.add_argument("--press-g", type=float, metavar="G", help="what the kitchen scale shows")
    parser.add_argument(
        "--hard-g", type=float, metavar="G", help="hold a hard press too, of this force, about 400"
    )
    parser.add_argument(
        "--hand", choices=("left", "right"), help="measure the touch of this hand alone"
    )
    parser.add_argument(
        "--base", default="auto", metavar="B", help="base model: FILE, none or auto"
    )
    parser.add_argument("--rounds", type=int, default=3, metavar="N", help="rounds of the pilot")
    parser.add_argument(
        "--round-s", type=float, default=60.0, metavar="S", help="length of a pilot round"
    )
    _add_place_arguments(parser)


def _add_place_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--by",
        metavar="WAY",
        help="surface: view, markers or touch; projector: markers, gray or touch",
    )
    parser.add_argument(
        "--width-mm", type=float, default=300.0, metavar="MM", help="width of the surface"
    )
    parser.add_argument(
        "--height-mm", type=float, default=200.0, metavar="MM", help="height of the surface"
    )
    add_screen(parser)
    parser.add_argument(
        "--picture", type=Path, metavar="PNG", help="write the projector's picture to a file"
    )
    parser.add_argument(
        "--size-px",
        metavar="WxH",
        help="size of that picture (default: 1920x1080), or of the projector, to be checked",
    )
    parser.add_argument("--marker", type=int, metavar="ID", help="id of the anchor (default: 0)")
    parser.add_argument(
        "--size-mm", type=float, metavar="MM", help="side of the anchor's black square"
    )
    parser.add_argument("--family", metavar="F", help="apriltag-36h11 (default) or aruco-4x4")


def run(options: argparse.Namespace) -> int:
    """Run the steps. Ctrl-C keeps the complete steps."""
    from halo_calibration.solvers.touch import StateValues
    from halo_service.app.calibration_ui.calibrate import CalibrateRequest, calibrate, pilot
    from halo_service.values import Side

    settings = settings_from(options)
    if options.step == "pilot":
        pilot(settings, options.rounds, options.round_s)
        return 0
    stated = StateValues(
        options.hover_mm, options.subtle_mm, options.touch_g, options.press_g, options.hard_g
    )
    side = Side[options.hand.upper()] if options.hand else Side.UNKNOWN
    place = _place_request(options)
    calibrate(
        settings,
        CalibrateRequest(options.step, options.script, stated, side, options.base, place),
    )
    return 0


def _place_request(options: argparse.Namespace) -> PlaceRequest:
    """Collect how surface, projector and anchor are found."""
    from halo_calibration.boards.board import ANCHOR, anchor
    from halo_service.app.calibration_ui.place import PlaceRequest
    from halo_service.app.projector.screens import ScreenRequest, size_of

    marker = anchor(
        ANCHOR.family.name if options.family is None else options.family,
        next(iter(ANCHOR.middles_mm)) if options.marker is None else options.marker,
        ANCHOR.size_mm if options.size_mm is None else options.size_mm,
    )
    size_px = None if options.size_px is None else size_of(options.size_px)
    screen = ScreenRequest(options.display, options.window, options.picture, size_px)
    return PlaceRequest(options.by, options.width_mm, options.height_mm, screen, marker)
