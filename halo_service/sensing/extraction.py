"""Stage 4: the halo's strength around one fingertip."""

from __future__ import annotations

import math

from halo_service.sensing.revealer import Revealed
from halo_service.values import Fingertip

PATCH_WIDTH_PX = 30
PATCH_HEIGHT_PX = 20
"""The patch that holds a whole halo at 0.5 m (paper 4.3.3)."""
LINE_PX = 15
"""How far beyond the tip the finger's line is followed (chosen: the halo's reach)."""


def extract(revealed: Revealed, tip: Fingertip) -> float:
    """Sum the excess depth of the halo pixels in the patch around the tip, mm px."""
    height, width = revealed.halo.shape
    left = round(tip.tip_px[0]) - PATCH_WIDTH_PX // 2
    top = round(tip.tip_px[1]) - PATCH_HEIGHT_PX // 2
    rows = slice(max(top, 0), min(max(top + PATCH_HEIGHT_PX, 0), height))
    columns = slice(max(left, 0), min(max(left + PATCH_WIDTH_PX, 0), width))
    halo = revealed.halo[rows, columns]
    return float(revealed.excess_mm[rows, columns][halo].sum())


def line_pixels(revealed: Revealed, tip: Fingertip) -> int:
    """Count halo pixels on the line from the distal joint through the tip and just beyond it.

    The paper (4.3.6) follows the line between tip and joint; a halo is on the surface, so we
    follow the same line on past the tip, where surface is.
    """
    dx, dy = tip.tip_px[0] - tip.distal_px[0], tip.tip_px[1] - tip.distal_px[1]
    length = math.hypot(dx, dy)
    if length == 0.0:
        return 0
    height, width = revealed.halo.shape
    count = 0
    for step in range(round(length) + LINE_PX):
        x = round(tip.distal_px[0] + dx * step / length)
        y = round(tip.distal_px[1] + dy * step / length)
        if 0 <= x < width and 0 <= y < height:
            count += bool(revealed.halo[y, x])
    return count
