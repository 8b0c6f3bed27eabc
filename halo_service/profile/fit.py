"""Measurements in, parts of a profile out. Pure: arrays and numbers, no I/O."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import cv2
import numpy as np

from halo_service.profile.model import Background, HeldState, TouchStates
from halo_service.values import Depth, Signal

WANTED_FRAMES = 60
"""The paper's background is the mean of 60 frames (section 4.3.1)."""
GOOD_FRACTION = 0.75
"""A pixel is valid with 45 good frames of 60: mixed pixels at edges come and go."""


def fit_background(depths: Sequence[Depth]) -> Background:
    """Average depth frames of the empty surface.

    `depths`: (H, W) uint16 mm, 0 = unmeasured; unmeasured values count for nothing.
    Raises `ValueError` for an empty sequence.
    """
    if not depths:
        raise ValueError("a background needs at least one depth frame")
    count = np.zeros(depths[0].shape, np.float64)
    total, squares = np.zeros_like(count), np.zeros_like(count)
    for depth in depths:
        value = depth.astype(np.float64)
        count += depth > 0
        total += value
        cv2.accumulateSquare(value, squares)
    seen = np.maximum(count, 1.0)
    mean = total / seen
    variance = np.maximum(squares / seen - mean * mean, 0.0)
    valid = count >= max(1.0, GOOD_FRACTION * len(depths))
    return Background(mean.astype(np.float32), np.sqrt(variance).astype(np.float32), valid)


def fit_states(
    held: Mapping[str, Sequence[Signal]],
    tops_mm: Sequence[float],
    *,
    hover_mm: float,
    subtle_mm: float,
    touch_g: float,
    pressure_g: float,
) -> TouchStates:
    """Reduce the signals seen while each of the four states was held to their medians.

    `held`: signals by state name (hover, subtle, touch, pressure); `tops_mm`: heights of the
    finger's upper side while it touched, nan where unmeasured.
    Raises `ValueError` when a state has no signal or they are out of order.
    """
    missing = [name for name in ("hover", "subtle", "touch", "pressure") if not held.get(name)]
    if missing:
        raise ValueError(f"no signal was seen in the state {' and '.join(missing)}")
    median = {name: float(np.median([s.corrected for s in held[name]])) for name in held}
    if not median["hover"] < median["subtle"] < median["touch"] < median["pressure"]:
        order = ", ".join(f"{name} {value:.0f}" for name, value in median.items())
        raise ValueError(
            f"the halo must grow from hover over subtle and touch to pressure: {order}"
        )
    seen_tops = [top for top in tops_mm if np.isfinite(top)]
    return TouchStates(
        hover=HeldState(median["hover"], hover_mm, 0.0),
        subtle=HeldState(median["subtle"], subtle_mm, 0.0),
        touch=HeldState(median["touch"], 0.0, touch_g),
        pressure=HeldState(median["pressure"], 0.0, pressure_g),
        line_px_at_hover=float(np.median([s.line_px for s in held["hover"]])),
        finger_thickness_mm=float(np.median(seen_tops)) if seen_tops else FINGER_THICKNESS_MM,
    )


FINGER_THICKNESS_MM = 13.0
"""Chosen: a fingertip from pad to nail, where none was measured."""
