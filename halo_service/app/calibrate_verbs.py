"""The verbs that teach the service a place and a finger, and show what came of it.

Rule: as `verbs`.
"""

from __future__ import annotations

import argparse
import sys
from dataclasses import replace
from typing import TYPE_CHECKING

from halo_service.errors import UserError

if TYPE_CHECKING:
    from halo_service.app.calibrate_place import PlaceRequest


def calibrate(options: argparse.Namespace) -> int:
    """Teach the service a place and a finger; after Ctrl-C what is missing is still missing."""
    from halo_calibration.touch import Stated
    from halo_service.app.calibrate import CalibrateRequest, pilot
    from halo_service.app.calibrate import calibrate as teach
    from halo_service.settings import load
    from halo_service.values import Side

    settings = load(options.config)
    source = replace(settings.source, name=options.source or settings.source.name)
    stated = Stated(options.hover_mm, options.subtle_mm, options.touch_g, options.press_g)
    side = Side[options.hand.upper()] if options.hand else Side.UNKNOWN
    settings = replace(settings, profile=options.profile or settings.profile, source=source)
    request = CalibrateRequest(
        options.step, options.script, stated, side, options.base, _places(options)
    )
    if options.step == "pilot":
        pilot(settings, options.rounds, options.round_s)
    else:
        teach(settings, request)
    return 0


def _places(options: argparse.Namespace) -> PlaceRequest:
    """Say how surface, projector and anchor shall be found."""
    from halo_calibration.boards import ANCHOR, anchor
    from halo_service.app.calibrate_place import PlaceRequest
    from halo_service.app.screens import FILE_PX, ScreenRequest, size_of

    marker = anchor(
        ANCHOR.family.name if options.family is None else options.family,
        next(iter(ANCHOR.middles_mm)) if options.marker is None else options.marker,
        ANCHOR.size_mm if options.size_mm is None else options.size_mm,
    )
    size_px = FILE_PX if options.size_px is None else size_of(options.size_px)
    screen = ScreenRequest(options.display, options.window, options.picture, size_px)
    return PlaceRequest(options.by, options.width_mm, options.height_mm, screen, marker)


def verify(options: argparse.Namespace) -> int:
    """Exit code 0: all crossings were touched, and nearly; 1: they were not."""
    from halo_service.app.screens import ScreenRequest
    from halo_service.app.verify import VerifyRequest
    from halo_service.app.verify import verify as look
    from halo_service.settings import load

    settings = load(options.config)
    source = replace(settings.source, name=options.source or settings.source.name)
    settings = replace(settings, profile=options.profile or settings.profile, source=source)
    screen = ScreenRequest(options.display, options.window)
    return look(settings, VerifyRequest(screen, options.service, options.within_mm))


def targets(options: argparse.Namespace) -> int:
    """Write the printable sheets."""
    from halo_calibration.targets import sheets
    from halo_service.files import appearing

    try:
        options.folder.mkdir(parents=True, exist_ok=True)
        for name, content in sheets().items():
            with appearing(options.folder / name) as file:
                file.write(content)
            print(f"halo: {options.folder / name}", file=sys.stderr)
    except OSError as error:
        raise UserError(
            f"'{options.folder}' cannot be written ({error.strerror or error}); choose another "
            f"folder"
        ) from error
    return 0
