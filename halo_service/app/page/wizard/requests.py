"""What the page asks of a step, checked. Pure."""

from __future__ import annotations

import math
from typing import Any

from halo_calibration.boards.board import ANCHOR, anchor
from halo_calibration.solvers.touch import StateValues
from halo_service.app.calibration_ui.calibrate import CalibrateRequest
from halo_service.app.calibration_ui.place import WAYS, PlaceRequest
from halo_service.errors import UserError
from halo_service.values import Side

STEPS = ("camera", "background", "surface", "touch", "sweep", "projector", "anchor", "verify")
PAGE_WAYS = {**WAYS, "surface": (*WAYS["surface"], "picture")}
SIZES_MM = (10.0, 3000.0)


def read_request(step: str, request: dict[str, Any]) -> CalibrateRequest:
    """Return the options of one step. Raises `UserError`."""
    by = request.get("by")
    known = PAGE_WAYS.get(step, ())
    if by is not None and by not in known:
        raise UserError(f"{step}: choose from: {', '.join(known)}")
    sides = {None: Side.UNKNOWN, "left": Side.LEFT, "right": Side.RIGHT}
    hand = request.get("hand")
    if hand not in sides:
        raise UserError("hand: choose from: left, right")
    place = PlaceRequest(
        by=by,
        width_mm=_number(request, "width_mm", 300.0, *SIZES_MM),
        height_mm=_number(request, "height_mm", 200.0, *SIZES_MM),
        marker=anchor(
            ANCHOR.family.name,
            round(_number(request, "marker", next(iter(ANCHOR.middles_mm)), 0, 10_000)),
            _number(request, "size_mm", ANCHOR.size_mm, 5.0, 1000.0),
        ),
        corners_px=_corners(request.get("corners_px", [])),
    )
    stated = StateValues(
        _optional(request, "hover_mm", 1.0, 100.0),
        _optional(request, "subtle_mm", 0.1, 20.0),
        _optional(request, "touch_g", 1.0, 5000.0),
        _optional(request, "press_g", 1.0, 5000.0),
        _optional(request, "hard_g", 1.0, 5000.0),
    )
    return CalibrateRequest(step, state_values=stated, side=sides[hand], place=place)


def _number(request: dict[str, Any], name: str, default: float, low: float, high: float) -> float:
    value = _optional(request, name, low, high)
    return default if value is None else value


def _optional(request: dict[str, Any], name: str, low: float, high: float) -> float | None:
    value = request.get(name)
    if value is None:
        return None
    if isinstance(value, bool) or not isinstance(value, int | float) or not low <= value <= high:
        raise UserError(f"{name} must be a number from {low:g} to {high:g}")
    return float(value)


def _corners(value: Any) -> tuple[tuple[float, float], ...]:
    match value:
        case []:
            return ()
        case [[_, _], [_, _], [_, _], [_, _]] if all(_is_px(x) for pair in value for x in pair):
            return tuple((float(x), float(y)) for x, y in value)
    raise UserError("the surface needs four corners in the picture")


def _is_px(value: Any) -> bool:
    number = isinstance(value, int | float) and not isinstance(value, bool)
    return number and math.isfinite(value) and -10_000 < value < 10_000
