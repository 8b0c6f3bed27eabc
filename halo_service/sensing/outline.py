"""Where a finger ends, by contrast: the outline of its round tip, to a fraction of a pixel.

A finger high up is nearer to the camera than the empty surface. A low one need not be: the halo
around it also lifts what the camera reads of its end, and eats millimetres of it. But the finger
is always nearer than the dent on both sides and ahead of it, and that edge is sharp.
"""

from __future__ import annotations

import math
from functools import lru_cache
from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from halo_service.sensing.detections import Pixel
from halo_service.sensing.finger_frame import Grid, blended, grid, moved, nearest
from halo_service.sensing.segmentation import Segmentation
from halo_service.sensing.silhouette import silhouette_end, stands_out
from halo_service.values import Depth

Floats = NDArray[np.float64]
Excess = NDArray[np.float32]

VIEW_PX = 48
"""Half the view: the tracker's error, and a flat finger's last segment behind it."""
CREST_MM = 4.0
"""Pixels within this of a row's nearest one are the finger's ridge: a wedge under it is not."""
MIDLINE_PX = (12, 18, 26)
"""How far behind its end the finger is followed, farther with each better direction."""
LEAST_ROWS, LEAST_PX = 5, 3
"""Minimum rows for a line, and pixels for a row."""
TURN = 0.5
"""The midline corrects the landmarks' direction by at most this slope a pass."""
AHEAD_PX = (-14, 22)
"""Along the finger: the search range for its end, from the rough one."""
ACROSS_PX = (-15, 16)
"""Across: the search range for its two sides."""
END_PX = (-10, 17)
SIDE_PX = (2, 12)
"""The edge must be within these."""
NO_RIDGE = 1e6
"""Farther than any measurement, mm."""
ROUND = 0.75
"""Share of the radius to both sides of the middle over which the round end is averaged."""
LEAST_STEP_MM = 5.0
"""A lower step is not an edge (chosen: above the noise of the averaged rows)."""
MISFIT = 0.5
"""Share of the radius by which a tip may be broader than its two (chosen: blur adds a quarter)."""
OFF_PX = 3.0
"""The two sides move the middle by at most this."""


class Outline(NamedTuple):
    """The end of one finger."""

    tip_px: Pixel
    """The foremost point of its outline."""
    direction: Pixel
    """Unit vector along the finger towards its end, in the image."""
    width_px: float
    """Of the fingertip, between its two sides; nan where they are not clear."""
    clear: bool
    """Whether the end is an edge that can be seen, not only the last finger pixels."""


class _View(NamedTuple):
    """The cropped arrays."""

    layers: Excess
    """(h, w, 2) excess depth, mm, and 1 where it was measured on this finger or the surface; both
    are 0 elsewhere, so that averages over either leave out the same."""
    ridge: Excess
    """(h, w) excess depth where it is the finger's, `NO_RIDGE` elsewhere."""


def outline(
    segmentation: Segmentation, depth: Depth, guess: Pixel, direction: Pixel, radius_px: float
) -> Outline | None:
    """Return the finger's outline near a guess, or None where no finger is.

    `segmentation`: what is neither hand nor free in it belongs to another finger and is ignored;
    `direction`: unit vector from joint to tip, approximate; `radius_px`: of the tip.
    """
    part = _around(segmentation, guess)
    own = (part.hand | part.free) & (depth[part.rows, part.columns] > 0)
    if own.size == 0:
        return None
    excess = np.where(own, part.excess_mm, np.float32(0.0))
    finger = stands_out(excess)
    rough = silhouette_end(finger, part.inside(guess), direction, radius_px)
    if rough is None:
        return None
    layers = np.asarray(cv2.merge([excess, own.astype(np.float32)]), dtype=np.float32)
    view = _View(layers, np.where(finger & own, excess, np.float32(NO_RIDGE)))
    found = _ended(view, *_midline(view, rough, direction, radius_px), radius_px)
    if _misfit(found, radius_px) > MISFIT * radius_px:
        # Knuckles next to a finger pull its midline towards them; the given direction does not.
        as_given = _ended(view, rough, direction, radius_px)
        if _misfit(as_given, radius_px) <= _misfit(found, radius_px):
            found = as_given
    tip = found.tip_px
    return found._replace(tip_px=(tip[0] + part.left, tip[1] + part.top))


def _ended(view: _View, tip: Pixel, direction: Pixel, radius_px: float) -> Outline:
    """Refine a finger's rough end on its outline; in the view's own pixels."""
    for _ in range(2):  # the second pass is in the middle, the first may be off it
        ahead, clear = _end(view, tip, direction, radius_px)
        tip = moved(tip, direction, ahead, 0.0)
        aside, width_px = _sides(view, tip, direction, radius_px)
        tip = moved(tip, direction, 0.0, aside)
    return Outline(tip, direction, width_px, clear)


def _misfit(found: Outline, radius_px: float) -> float:
    """Return how far from a fingertip's breadth an end's two sides are, px; inf without an edge."""
    if not found.clear:
        return math.inf
    return radius_px if math.isnan(found.width_px) else abs(found.width_px - 2.0 * radius_px)


def _around(segmentation: Segmentation, guess: Pixel) -> Segmentation:
    column, row = (round(each) for each in segmentation.inside(guess))
    rows = slice(max(row - VIEW_PX, 0), max(row + VIEW_PX, 0))
    return segmentation.cut((rows, slice(max(column - VIEW_PX, 0), max(column + VIEW_PX, 0))))


def _midline(view: _View, tip: Pixel, direction: Pixel, radius_px: float) -> tuple[Pixel, Pixel]:
    """Follow the finger back from its end: return the end in its middle, and its direction."""
    for back_px in MIDLINE_PX:
        at = _behind(back_px, radius_px)
        read = nearest(view.ridge, tip, direction, at, NO_RIDGE)
        highest = np.minimum(read.min(axis=1) + CREST_MM, np.float32(NO_RIDGE - 1.0))
        crest = read <= highest[:, None]
        count = np.count_nonzero(crest, axis=1)
        rows = count >= LEAST_PX
        if np.count_nonzero(rows) < LEAST_ROWS:
            break
        middles = (crest @ at.across[0])[rows] / count[rows]
        slope, middle = _line(at.along[rows, 0].astype(np.float64), middles)
        slope = min(max(slope, -TURN), TURN)
        tip = moved(tip, direction, 0.0, middle)
        length = math.hypot(1.0, slope)
        direction = (
            (direction[0] - slope * direction[1]) / length,
            (direction[1] + slope * direction[0]) / length,
        )
    return tip, direction


def _end(view: _View, tip: Pixel, direction: Pixel, radius_px: float) -> tuple[float, bool]:
    """Return how far ahead of `tip` the finger ends, px, and whether there is an edge."""
    profile = _profile(view, tip, direction, _ahead(radius_px), 1)
    return (0.0, False) if profile is None else _edge(profile, AHEAD_PX[0], END_PX)


def _sides(view: _View, tip: Pixel, direction: Pixel, radius_px: float) -> tuple[float, float]:
    """Return the offset of the finger's middle from `tip`, and its width, px; 0 and nan if unclear.

    Read where the tip is widest and a little behind.
    """
    profile = _profile(view, tip, direction, _beside(radius_px), 0)
    if profile is None:
        return 0.0, math.nan
    right, right_clear = _edge(profile, ACROSS_PX[0], SIDE_PX)
    left, left_clear = _edge(profile[::-1], ACROSS_PX[0], SIDE_PX)
    if not (left_clear and right_clear):
        return 0.0, math.nan
    return min(max((right - left) / 2.0, -OFF_PX), OFF_PX), right + left


@lru_cache(maxsize=16)
def _behind(back_px: int, radius_px: float) -> Grid:
    half = math.ceil(radius_px) + 1
    return grid(np.arange(-back_px, -2), np.arange(-half, half + 1))


@lru_cache(maxsize=16)
def _ahead(radius_px: float) -> Grid:
    half = math.floor(ROUND * radius_px)
    straight = grid(np.arange(*AHEAD_PX), np.arange(-half, half + 1))
    # Bent like the end itself, so that the edge is at one place in all columns.
    bend = radius_px - np.sqrt(radius_px**2 - straight.across**2)
    return Grid((straight.along - bend).astype(np.float32), straight.across)


@lru_cache(maxsize=16)
def _beside(radius_px: float) -> Grid:
    back = np.arange(-math.ceil(2.0 * radius_px), -math.floor(0.7 * radius_px))
    return grid(back, np.arange(*ACROSS_PX))


def _profile(view: _View, tip: Pixel, direction: Pixel, at: Grid, axis: int) -> Floats | None:
    """Average the excess over one direction, by what was measured; gaps are bridged."""
    read = blended(view.layers, tip, direction, at)
    total, weight = read.sum(axis=axis, dtype=np.float64).T
    seen = weight > 0.15 * read.shape[axis]
    if np.count_nonzero(seen) < LEAST_ROWS:
        return None
    if seen.all():
        return np.asarray(total / weight)
    place = np.arange(len(total), dtype=np.float64)
    return np.interp(place, place[seen], total[seen] / weight[seen])


def _edge(profile: Floats, first_px: int, within_px: tuple[int, int]) -> tuple[float, bool]:
    """Return where a profile rises most, half way up the step, and whether that is an edge.

    `first_px`: where the profile begins; `within_px`: the range of the edge.
    """
    a, b = within_px[0] - first_px, within_px[1] - first_px + 1
    rise = profile[a + 1 : b + 1] + profile[a + 2 : b + 2] - profile[a - 2 : b - 2]
    rise -= profile[a - 1 : b - 1]
    k = min(max(a + int(np.argmax(rise)), 3), len(profile) - 4)
    near = profile[k - 3 : k + 4].tolist()
    low, high = 0.5 * (near[0] + near[1]), 0.5 * (near[5] + near[6])
    half = 0.5 * (low + high)
    for j in (2, 3, 1, 4):
        if near[j] < half <= near[j + 1]:
            share = (half - near[j]) / (near[j + 1] - near[j])
            return first_px + k - 3 + j + share, high - low > LEAST_STEP_MM
    return float(first_px + k), False


def _line(x: Floats, y: Floats) -> tuple[float, float]:
    """Return slope and offset at 0 of the line through points."""
    mean_x, mean_y = float(x.sum()) / x.size, float(y.sum()) / x.size
    dx = x - mean_x
    slope = float(dx @ y / (dx @ dx))
    return slope, mean_y - slope * mean_x
