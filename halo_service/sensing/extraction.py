"""Stage 4: the halo's strength around one fingertip."""

from __future__ import annotations

import math

import numpy as np

from halo_service.sensing.revealer import Revealed
from halo_service.values import Fingertip

PATCH_WIDTH_PX = 30
PATCH_HEIGHT_PX = 20
"""The patch that holds a whole halo at 0.5 m (paper 4.3.3)."""
ACROSS = np.arange(PATCH_WIDTH_PX) - PATCH_WIDTH_PX // 2
ALONG = PATCH_HEIGHT_PX // 2 - np.arange(PATCH_HEIGHT_PX)[:, None]
"""The patch's columns beside the finger's line and its rows along it, px from the tip."""
FREE_PX = 493
"""Pixels of the patch that a lone finger leaves free (chosen: it hides a sixth)."""
LEAST_FREE_PX = 120
"""No fewer stand for all: a quarter."""
LINE_PX = 15
"""How far beyond the tip the finger's line is followed (chosen: the halo's reach)."""


def extract(revealed: Revealed, tip: Fingertip) -> float:
    """Sum the excess depth of the halo pixels in the patch around the tip, mm px.

    The patch lies across the finger. Where more of it is hidden than by a lone finger, by the
    hand itself, by a neighbour or by pixels that measured nothing, what is left stands for all.
    """
    dx, dy = _direction(tip)
    end = revealed.inside(tip.tip_px)
    # The edge of a silhouette lies between two pixels, where rounding would waver.
    x = np.floor(end[0] + ALONG * dx - ACROSS * dy).astype(np.intp)
    y = np.floor(end[1] + ALONG * dy + ACROSS * dx).astype(np.intp)
    height, width = revealed.halo.shape
    inside = (x >= 0) & (x < width) & (y >= 0) & (y < height)
    x, y = x[inside], y[inside]
    signal = float(revealed.excess_mm[y, x][revealed.halo[y, x]].sum())
    free = np.count_nonzero(revealed.free[y, x])
    return signal * FREE_PX / max(free, LEAST_FREE_PX)


def _direction(tip: Fingertip) -> tuple[float, float]:
    dx, dy = tip.tip_px[0] - tip.distal_px[0], tip.tip_px[1] - tip.distal_px[1]
    length = math.hypot(dx, dy)
    return (dx / length, dy / length) if length > 0.0 else (0.0, -1.0)


def line_pixels(revealed: Revealed, tip: Fingertip) -> int:
    """Count halo pixels on the line from the distal joint through the tip and just beyond it.

    The paper (4.3.6) follows the line between tip and joint; a halo is on the surface, so we
    follow the same line on past the tip, where surface is.
    """
    dx, dy = tip.tip_px[0] - tip.distal_px[0], tip.tip_px[1] - tip.distal_px[1]
    length = math.hypot(dx, dy)
    if length == 0.0:
        return 0
    joint = revealed.inside(tip.distal_px)
    height, width = revealed.halo.shape
    count = 0
    for step in range(round(length) + LINE_PX):
        x = round(joint[0] + dx * step / length)
        y = round(joint[1] + dy * step / length)
        if 0 <= x < width and 0 <= y < height:
            count += bool(revealed.halo[y, x])
    return count
