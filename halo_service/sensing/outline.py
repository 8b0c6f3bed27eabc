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

from halo_service.sensing.finger_fit import fit_finger
from halo_service.sensing.finger_frame import FingerFrame, Grid, blended, grid, nearest
from halo_service.sensing.segmentation import Segmentation
from halo_service.sensing.silhouette import stands_out
from halo_service.values import Depth

Floats = NDArray[np.float64]
Excess = NDArray[np.float32]

VIEW_MM = 48.0
"""Half the view: the tracker's error, and a flat finger's last segment behind it."""
CREST_MM = 4.0
"""Pixels within this of a row's nearest one are the finger's ridge: a wedge under it is not."""
MIDLINE_MM = (12, 18, 26)
"""How far behind its end the finger is followed, farther with each better direction."""
LEAST_ROWS, LEAST_MM = 5, 3
"""Minimum rows, 1 mm apart, for a line, and width of a row."""
TURN = 0.5
"""The midline corrects the landmarks' direction by at most this slope a pass."""
AHEAD_MM = (-14, 22)
"""Along the finger: the search range for its end, from the rough one."""
ACROSS_MM = (-15, 16)
"""Across: the search range for its two sides."""
END_MM = (-10, 17)
SIDE_MM = (2, 12)
"""The edge must be within these."""
SOLID_MM = 20.0
"""Height added to what infrared shows (chosen: more than any halo takes from a finger's end)."""
NO_RIDGE = 1e6
"""Farther than any measurement, mm."""
ROUND = 0.75
"""Share of the radius to both sides of the middle over which the round end is averaged."""
LEAST_STEP_MM = 5.0
"""A lower step is not an edge (chosen: above the noise of the averaged rows)."""
MISFIT = 0.5
"""Share of the radius by which a tip may be broader than its two (chosen: blur adds a quarter)."""
TURNED = 0.45
"""The landmarks' direction is seldom off by more than this sine (measured: 10 degrees)."""
LEAST_SHARE = 0.35
"""A pixel that is this finger's with a smaller probability is not searched for its edge."""
LEAVES_MM, LEAVES_PX = 6.0, 2.0
"""An edge farther from the fitted end than both together is another's (chosen: three samples of the
fit, and what blur adds to the mask)."""
OFF_MM = 3.0
"""The two sides move the middle by at most this."""


class Outline(NamedTuple):
    """The end of one finger."""

    place: FingerFrame
    """The foremost point of its outline, and the direction along the finger."""
    width_mm: float
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
    segmentation: Segmentation, depth: Depth, guess: FingerFrame, radius_mm: float
) -> Outline | None:
    """Return the finger's outline near a guess, or None where no finger is.

    `segmentation`: its `share` says which pixels belong to other fingers, and these are ignored;
    `radius_mm`: of the tip.
    """
    part = _around(segmentation, guess)
    measured = depth[part.rows, part.columns] > 0
    if measured.size == 0:
        return None
    if part.hidden is not None:
        measured &= ~part.hidden
    share = np.float32(1.0) if part.share is None else part.share
    own = measured & (part.free | (share > LEAST_SHARE))
    # What infrared shows stands out, whatever its depth reads.
    standing_mm: Excess = part.excess_mm - np.float32(SOLID_MM) * part.solid
    finger = stands_out(standing_mm * measured, guess.px_per_mm)
    mask = (np.float32(2.0) * share * finger - 1.0) * measured
    fit = fit_finger(mask, part.within(guess), radius_mm)
    if fit is None:
        return None
    excess = standing_mm * own
    layers = np.asarray(cv2.merge([excess, own.astype(np.float32)]), dtype=np.float32)
    view = _View(layers, np.where(finger & own, excess, np.float32(NO_RIDGE)))
    found = _refined(view, fit.place, guess, radius_mm)
    x, y = found.place.tip_px
    return found._replace(place=found.place._replace(tip_px=(x + part.left, y + part.top)))


def _refined(view: _View, fit: FingerFrame, guess: FingerFrame, radius_mm: float) -> Outline:
    """Refine a fitted place on the finger's edges; the place itself where no edge is near it."""
    aside, _ = _sides(view, fit, radius_mm)
    start = fit.moved(0.0, aside)
    found = [_ended(view, _midline(view, start, radius_mm), radius_mm)]
    if _turned(found[0].place, guess) > TURNED or _misfit(found[0], radius_mm) > MISFIT * radius_mm:
        # Knuckles next to a finger pull its midline towards them; the given direction does not.
        found.append(_ended(view, start._replace(direction=guess.direction), radius_mm))
    leaves_px = LEAVES_PX + LEAVES_MM * fit.px_per_mm
    near = [each for each in found if math.dist(each.place.tip_px, fit.tip_px) <= leaves_px]
    return min(
        near, key=lambda each: _misfit(each, radius_mm), default=Outline(fit, math.nan, False)
    )


def _ended(view: _View, place: FingerFrame, radius_mm: float) -> Outline:
    """Refine a finger's rough end on its outline; in the view's own pixels."""
    for _ in range(2):  # the second pass is in the middle, the first may be off it
        ahead, clear = _end(view, place, radius_mm)
        place = place.moved(ahead)
        aside, width_mm = _sides(view, place, radius_mm)
        place = place.moved(0.0, aside)
    return Outline(place, width_mm, clear)


def _turned(place: FingerFrame, guess: FingerFrame) -> float:
    """Return the sine of the angle between two fingers."""
    (ax, ay), (bx, by) = place.direction, guess.direction
    return abs(ax * by - ay * bx)


def _misfit(found: Outline, radius_mm: float) -> float:
    """Return how far from a fingertip's breadth an end's two sides are, mm; inf without an edge."""
    if not found.clear:
        return math.inf
    return radius_mm if math.isnan(found.width_mm) else abs(found.width_mm - 2.0 * radius_mm)


def _around(segmentation: Segmentation, guess: FingerFrame) -> Segmentation:
    column, row = (round(each) for each in segmentation.inside(guess.tip_px))
    half_px = round(VIEW_MM * guess.px_per_mm)
    rows = slice(max(row - half_px, 0), max(row + half_px, 0))
    return segmentation.cut((rows, slice(max(column - half_px, 0), max(column + half_px, 0))))


def _midline(view: _View, place: FingerFrame, radius_mm: float) -> FingerFrame:
    """Follow the finger back from its end: return the end in its middle, and its direction."""
    for back_mm in MIDLINE_MM:
        at = _behind(back_mm, radius_mm)
        read = nearest(view.ridge, place, at, NO_RIDGE)
        highest = np.minimum(read.min(axis=1) + CREST_MM, np.float32(NO_RIDGE - 1.0))
        crest = read <= highest[:, None]
        count = np.count_nonzero(crest, axis=1)
        rows = count >= LEAST_MM
        if np.count_nonzero(rows) < LEAST_ROWS:
            break
        middles = (crest @ at.across[0])[rows] / count[rows]
        slope, middle = _line(at.along[rows, 0].astype(np.float64), middles)
        slope = min(max(slope, -TURN), TURN)
        length, (dx, dy) = math.hypot(1.0, slope), place.direction
        turned = ((dx - slope * dy) / length, (dy + slope * dx) / length)
        place = place.moved(0.0, middle)._replace(direction=turned)
    return place


def _end(view: _View, place: FingerFrame, radius_mm: float) -> tuple[float, bool]:
    """Return how far ahead of the tip the finger ends, mm, and whether there is an edge."""
    profile = _profile(view, place, _ahead(radius_mm), 1)
    return (0.0, False) if profile is None else _edge(profile, AHEAD_MM[0], END_MM)


def _sides(view: _View, place: FingerFrame, radius_mm: float) -> tuple[float, float]:
    """Return the offset of the finger's middle from the tip, and its width, mm.

    Where a neighbour touches one side, the other and the radius give the middle; the width is nan
    then. Read where the tip is widest and a little behind.
    """
    profile = _profile(view, place, _beside(radius_mm), 0)
    if profile is None:
        return 0.0, math.nan
    right, right_clear = _edge(profile, ACROSS_MM[0], SIDE_MM)
    left, left_clear = _edge(profile[::-1], ACROSS_MM[0], SIDE_MM)
    width_mm = right + left if left_clear and right_clear else math.nan
    if not right_clear:
        right = 2.0 * radius_mm - left if left_clear else left
    elif not left_clear:
        left = 2.0 * radius_mm - right
    return min(max((right - left) / 2.0, -OFF_MM), OFF_MM), width_mm


@lru_cache(maxsize=16)
def _behind(back_mm: int, radius_mm: float) -> Grid:
    half = math.ceil(radius_mm) + 1
    return grid(np.arange(-back_mm, -2), np.arange(-half, half + 1))


@lru_cache(maxsize=16)
def _ahead(radius_mm: float) -> Grid:
    half = math.floor(ROUND * radius_mm)
    straight = grid(np.arange(*AHEAD_MM), np.arange(-half, half + 1))
    # Bent like the end itself, so that the edge is at one place in all columns.
    bend = radius_mm - np.sqrt(radius_mm**2 - straight.across**2)
    return Grid((straight.along - bend).astype(np.float32), straight.across)


@lru_cache(maxsize=16)
def _beside(radius_mm: float) -> Grid:
    back = np.arange(-math.ceil(2.0 * radius_mm), -math.floor(0.7 * radius_mm))
    return grid(back, np.arange(*ACROSS_MM))


def _profile(view: _View, place: FingerFrame, at: Grid, axis: int) -> Floats | None:
    """Average the excess over one direction, by what was measured; gaps are bridged."""
    read = blended(view.layers, place, at)
    total, weight = read.sum(axis=axis, dtype=np.float64).T
    seen = weight > 0.15 * read.shape[axis]
    if np.count_nonzero(seen) < LEAST_ROWS:
        return None
    if seen.all():
        return np.asarray(total / weight)
    rows = np.arange(len(total), dtype=np.float64)
    return np.interp(rows, rows[seen], total[seen] / weight[seen])


def _edge(profile: Floats, first_mm: int, within_mm: tuple[int, int]) -> tuple[float, bool]:
    """Return where a profile rises most, half way up the step, and whether that is an edge.

    `first_mm`: where the profile begins; `within_mm`: the range of the edge.
    """
    a, b = within_mm[0] - first_mm, within_mm[1] - first_mm + 1
    rise = profile[a + 1 : b + 1] + profile[a + 2 : b + 2] - profile[a - 2 : b - 2]
    rise -= profile[a - 1 : b - 1]
    k = min(max(a + int(np.argmax(rise)), 3), len(profile) - 4)
    near = profile[k - 3 : k + 4].tolist()
    low, high = 0.5 * (near[0] + near[1]), 0.5 * (near[5] + near[6])
    half = 0.5 * (low + high)
    for j in (2, 3, 1, 4):
        if near[j] < half <= near[j + 1]:
            share = (half - near[j]) / (near[j + 1] - near[j])
            return first_mm + k - 3 + j + share, high - low > LEAST_STEP_MM
    return float(first_mm + k), False


def _line(x: Floats, y: Floats) -> tuple[float, float]:
    """Return slope and offset at 0 of the line through points."""
    mean_x, mean_y = float(x.sum()) / x.size, float(y.sum()) / x.size
    dx = x - mean_x
    slope = float(dx @ y / (dx @ dx))
    return slope, mean_y - slope * mean_x
