"""What `halo calibrate`, `verify` and `targets` can be told on the command line. Nothing heavy is
imported to read it."""

from __future__ import annotations

import argparse
from pathlib import Path

from halo_service.app import calibrate_verbs as verbs


def add_calibrate(verb: argparse.ArgumentParser) -> None:
    """Give `halo calibrate` its options."""
    verb.add_argument(
        "step",
        nargs="?",
        choices=("background", "surface", "touch", "sweep", "projector", "anchor", "pilot"),
        metavar="STEP",
        help="background, surface, touch, sweep; projector, anchor, pilot; without one all of the "
        "first four that are missing",
    )
    verb.add_argument("--source", metavar="S", help="as for serve")
    verb.add_argument("--script", type=Path, metavar="FILE", help="steps of a recording, by time")
    verb.add_argument("--hover-mm", type=float, metavar="MM", help="height of the hover spacer")
    verb.add_argument("--subtle-mm", type=float, metavar="MM", help="height of the subtle spacer")
    verb.add_argument("--touch-g", type=float, metavar="G", help="force of the relaxed touch")
    verb.add_argument("--press-g", type=float, metavar="G", help="what the kitchen scale shows")
    verb.add_argument("--hand", choices=("left", "right"), help="touch parameters for this hand")
    verb.add_argument("--base", default="auto", metavar="B", help="base model: FILE, none or auto")
    verb.add_argument("--rounds", type=int, default=3, metavar="N", help="of the pilot")
    verb.add_argument("--round-s", type=float, default=60.0, metavar="S", help="of the pilot")
    _place_options(verb)
    verb.set_defaults(run=verbs.calibrate)


def add_verify(verb: argparse.ArgumentParser) -> None:
    """Give `halo verify` its options."""
    verb.add_argument("--source", metavar="S", help="as for serve")
    verb.add_argument(
        "--from",
        dest="service",
        nargs="?",
        const="osc://127.0.0.1:9000",
        metavar="URL",
        help="the fingers of a running service (default: osc://127.0.0.1:9000), not a source's",
    )
    _screen_options(verb)
    verb.add_argument(
        "--within-mm", type=float, default=5.0, metavar="MM", help="what 95 %% must keep to pass"
    )
    verb.set_defaults(run=verbs.verify)


def add_targets(verb: argparse.ArgumentParser) -> None:
    """Give `halo targets` its options."""
    verb.add_argument("folder", type=Path, metavar="FOLDER", help="made where it is missing")
    verb.set_defaults(run=verbs.targets)


def _place_options(verb: argparse.ArgumentParser) -> None:
    verb.add_argument(
        "--by", metavar="WAY", help="surface: view, markers, touch; projector: markers, gray, touch"
    )
    verb.add_argument("--width-mm", type=float, default=300.0, metavar="MM", help="of the surface")
    verb.add_argument("--height-mm", type=float, default=200.0, metavar="MM", help="of the surface")
    _screen_options(verb)
    verb.add_argument(
        "--picture", type=Path, metavar="PNG", help="write the projector's picture instead"
    )
    verb.add_argument("--size-px", metavar="WxH", help="of that picture (default: 1920x1080)")
    verb.add_argument("--marker", type=int, metavar="ID", help="the anchor's (default: 0)")
    verb.add_argument("--size-mm", type=float, metavar="MM", help="side of its black square")
    verb.add_argument("--family", metavar="F", help="apriltag-36h11 (default) or aruco-4x4")


def _screen_options(verb: argparse.ArgumentParser) -> None:
    verb.add_argument(
        "--display", type=int, default=0, metavar="N", help="which is the projector, from 0"
    )
    verb.add_argument("--window", action="store_true", help="a window instead of a whole display")
