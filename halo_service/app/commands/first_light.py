"""`halo first-light`: what works on the table of somebody who owns a camera."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from halo_service.app.options import add_profile, add_source, settings_from

SUMMARY = "check a camera and a table in half an hour: calibration, guided touches, a report"
EXAMPLE = "halo first-light my-table --profile desk"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of the command."""
    add_profile(parser)
    parser.add_argument("folder", type=Path, metavar="FOLDER", help="where the report goes")
    add_source(parser)
    parser.add_argument(
        "--brief", action="store_true", help="four crosses, two heights and two forces, once each"
    )
    parser.add_argument(
        "--coins",
        metavar="MM,MM,...",
        type=_levels,
        help="heights of stacks of coins, instead of the printed pegs",
    )
    parser.add_argument(
        "--forces",
        metavar="G,G,...",
        type=_levels,
        help="what the scale shall show; none: there is no scale",
    )
    parser.add_argument("--hover-mm", type=float, metavar="MM", help="height of the hover spacer")
    parser.add_argument("--subtle-mm", type=float, metavar="MM", help="height of the subtle spacer")
    parser.add_argument("--press-g", type=float, metavar="G", help="what the kitchen scale shows")
    parser.add_argument("--silent", action="store_true", help="no voice and no tones")


def run(options: argparse.Namespace) -> int:
    """Go the whole way, and print where the report is."""
    from halo_calibration.solvers.touch import StateValues
    from halo_service.app.first_light.plan import PlanOptions
    from halo_service.app.first_light.run import FirstLightRequest, first_light

    plan = PlanOptions(brief=options.brief)
    if options.coins is not None:
        plan = PlanOptions(options.coins, coins=True, brief=options.brief)
    if options.forces is not None:
        plan = PlanOptions(plan.heights_mm, plan.coins, options.forces, options.brief)
    stated = StateValues(options.hover_mm, options.subtle_mm, None, options.press_g)
    request = FirstLightRequest(options.folder, plan, stated, not options.silent)
    print(first_light(settings_from(options), request))
    print("next: open it in a browser, and print it or send the folder", file=sys.stderr)
    return 0


def _levels(text: str) -> tuple[float, ...]:
    if text == "none":
        return ()
    try:
        return tuple(float(each) for each in text.split(","))
    except ValueError:
        raise argparse.ArgumentTypeError(f"{text!r} must be numbers with commas between") from None
