"""`halo calibrate surface`, `projector`, `anchor`: where things are on the table."""

from __future__ import annotations

from contextlib import nullcontext
from dataclasses import dataclass, field

import numpy as np

from halo_calibration.boards.board import ANCHOR, Printed
from halo_calibration.guided.guide import GuidedCalibration
from halo_calibration.guided.place import GuidedPlace
from halo_calibration.guided.projector import GuidedProjector, Screen
from halo_calibration.steps import Change, surface_change
from halo_calibration.steps.place import dragged_change
from halo_service.app.projector.screens import ScreenRequest, screen_for
from halo_service.errors import UserError
from halo_service.profile import Profile
from halo_service.sources import Exposing, Source

PLACED = ("surface", "projector", "anchor")
"""The steps that run here."""
WAYS = {"surface": ("view", "markers", "touch"), "projector": ("markers", "gray", "touch")}
"""The ways to do each step; the first is the default."""


@dataclass(frozen=True, slots=True)
class PlaceRequest:
    """What the command line asks of these steps."""

    by: str | None = None
    """One of the step's `WAYS`."""
    width_mm: float = 300.0
    height_mm: float = 200.0
    """Size of the surface, unless its corners are touched."""
    screen: ScreenRequest = field(default_factory=ScreenRequest)
    marker: Printed = ANCHOR
    corners_px: tuple[tuple[float, float], ...] = ()
    """Corners in the depth picture for the way `picture`, far left first, clockwise; px."""


def place(
    name: str,
    guided: GuidedCalibration,
    source: Source,
    request: PlaceRequest,
    profile: Profile,
    screen: Screen | None = None,
) -> Change:
    """Run one of these steps for a profile; `screen`: None: the one that the request names.

    Raises `UserError` and its `CalibrationError`.
    """
    way = _way(name, request.by)
    if name == "anchor":
        return GuidedPlace(guided).marker(profile, request.marker)
    if name == "projector":
        expose = source.expose if isinstance(source, Exposing) else None
        opened = nullcontext(screen) if screen else screen_for(source, request.screen)
        with opened as shown:
            return GuidedProjector(guided, shown, expose).projector(profile, way)
    if way == "markers":
        return GuidedPlace(guided).sheet(profile, request.width_mm, request.height_mm)
    if way == "touch":
        return GuidedPlace(guided).corners(profile)
    if way == "picture":
        return dragged_change(guided.setup, np.array(request.corners_px), profile)
    return surface_change(guided.setup, request.width_mm, request.height_mm)


def _way(name: str, by: str | None) -> str:
    if (name, by) == ("surface", "picture"):  # a terminal shows no picture
        return "picture"
    known = WAYS.get(name, ("markers",))
    if by is not None and by not in known:
        raise UserError(f"calibrate {name}: unknown --by '{by}'; choose from: {', '.join(known)}")
    return by or known[0]
