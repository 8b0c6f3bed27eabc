"""Where a finger ends, by contrast: the outline of its round tip, to a fraction of a pixel.

A finger high up is nearer to the camera than the empty surface. A low one need not be: the halo
around it also lifts what the camera reads of its end, and eats millimetres of it. But the finger
is always nearer than the dent on both sides and ahead of it, and that edge is sharp.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from halo_service.sensing.revealer import Revealed
from halo_service.sensing.sightings import Pixel
from halo_service.values import Depth

Floats = NDArray[np.float64]
Excess = NDArray[np.float32]

VIEW_PX = 48
"""Half the view: the tracker's error, and a flat finger's last segment behind it."""
ROI_PX = 22
"""Half the window in which the silhouette's end is sought: a fast finger's way in one frame."""
NEARER_MM = 4.0
"""What reads nearer than the surface by this much is finger (chosen: above the noise)."""
STANDS_OUT_MM = 8.0
"""What reads nearer than its surroundings by this much is finger too (chosen: half of the least
step between a finger and the dent around it, and above the noise of 3 x 3 pixels)."""
FILLED_PX = 21
"""A valley narrower than this is a finger: half as wide again as a finger at 0.5 m."""
LEAST_HAND_PX = 20
"""Fewer finger pixels in the window are noise."""
CREST_MM = 4.0
"""What is this near to a row's nearest pixel is the finger's ridge: a wedge under it is not."""
MIDLINE_PX = (12, 18, 26)
"""How far behind its end the finger is followed, farther as its direction gets surer."""
LEAST_ROWS, LEAST_PX = 5, 3
"""Fewer rows make no line, fewer pixels no row."""
TURN = 0.5
"""The midline corrects the landmarks' direction by at most this slope a pass."""
AHEAD = np.arange(-14.0, 22.0)
"""Along the finger: where its end is sought, px from the rough one."""
ACROSS = np.arange(-15.0, 16.0)
"""Across: where its two sides are sought."""
END_PX = (-10.0, 17.0)
SIDE_PX = (2.0, 12.0)
"""Within these the edge must lie."""
ROUND = 0.75
"""Share of the radius to both sides of the middle over which the round end is averaged."""
LEAST_STEP_MM = 5.0
"""A lower step is no edge (chosen: above the noise of the rows that are averaged)."""
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
    excess: Excess
    measured: NDArray[np.float32]
    """1 where a depth of this finger or of the surface around it was measured."""
    left: int
    top: int


def outline(
    revealed: Revealed, depth: Depth, guess: Pixel, direction: Pixel, radius_px: float
) -> Outline | None:
    """Return the finger's outline near a guess, or None where no finger is.

    `revealed`: what is neither hand nor free in it is another finger's, and not looked at;
    `direction`: unit vector from joint to tip, as well as it is known; `radius_px`: of the tip.
    """
    view = _look(revealed, depth, guess)
    if view is None:
        return None
    finger = stands_out(view.excess)
    tip = (guess[0] - view.left, guess[1] - view.top)
    rough = silhouette_end(finger, tip, direction, radius_px)
    if rough is None:
        return None
    tip, direction = _midline(view, finger, rough, direction, radius_px)
    for _ in range(2):  # the second pass stands in the middle, the first may stand beside it
        ahead, clear = _end(view, tip, direction, radius_px)
        tip = _moved(tip, direction, ahead, 0.0)
        aside, width_px = _sides(view, tip, direction, radius_px)
        tip = _moved(tip, direction, 0.0, aside)
    return Outline((tip[0] + view.left, tip[1] + view.top), direction, width_px, clear)


def stands_out(excess_mm: Excess) -> NDArray[np.bool_]:
    """Return the mask of what is nearer than the surface, or than the dent around it."""
    smooth = cv2.blur(excess_mm, (3, 3))
    kernel = np.ones((FILLED_PX, FILLED_PX), np.uint8)
    filled = cv2.morphologyEx(smooth, cv2.MORPH_CLOSE, kernel)
    return np.asarray((smooth < -NEARER_MM) | (filled - smooth > STANDS_OUT_MM))


def silhouette_end(
    finger: NDArray[np.bool_], guess: Pixel, direction: Pixel, radius_px: float
) -> Pixel | None:
    """Return the end of the finger's mask near a guess, to a few px; None where no finger is."""
    tip, half_px = guess, 1.3 * radius_px
    for _ in range(2):  # the second pass looks straight along the finger, the first may look askew
        left, top = max(round(tip[0]) - ROI_PX, 0), max(round(tip[1]) - ROI_PX, 0)
        window = finger[top : max(top + 2 * ROI_PX, 0), left : max(left + 2 * ROI_PX, 0)]
        rows, columns = np.nonzero(window)
        dx, dy = columns + left - tip[0], rows + top - tip[1]
        along = dx * direction[0] + dy * direction[1]
        across = dy * direction[0] - dx * direction[1]
        near = np.abs(across) <= half_px
        if np.count_nonzero(near) < LEAST_HAND_PX:
            return None
        along, across = along[near], across[near]
        end = float(np.partition(along, -3)[-3])  # the third farthest: two may be stray pixels
        middle = float(across[along > end - half_px].mean())
        tip = _moved(tip, direction, end, middle)
    return tip


def straight(
    view_mm: Excess, tip: Pixel, direction: Pixel, along: Floats, across: Floats
) -> Excess:
    """Sample an image in a finger's own rows and columns, px from its tip; bilinear, 0 outside."""
    x = tip[0] + along * direction[0] - across * direction[1]
    y = tip[1] + along * direction[1] + across * direction[0]
    sampled = cv2.remap(view_mm, x.astype(np.float32), y.astype(np.float32), cv2.INTER_LINEAR)
    return np.asarray(sampled)


def _look(revealed: Revealed, depth: Depth, guess: Pixel) -> _View | None:
    column, row = (round(each) for each in revealed.inside(guess))
    left, top = max(column - VIEW_PX, 0), max(row - VIEW_PX, 0)
    seen = revealed.cut((slice(top, max(row + VIEW_PX, 0)), slice(left, max(column + VIEW_PX, 0))))
    height, width = seen.hand.shape
    measured = depth[seen.top : seen.top + height, seen.left : seen.left + width] > 0
    own = (seen.hand | seen.free) & measured
    if own.size == 0:
        return None
    excess = np.where(own, seen.excess_mm, np.float32(0.0))
    return _View(excess, own.astype(np.float32), seen.left, seen.top)


def _midline(
    view: _View, finger: NDArray[np.bool_], tip: Pixel, direction: Pixel, radius_px: float
) -> tuple[Pixel, Pixel]:
    """Follow the finger back from its end: return the end in its middle, and its direction."""
    side = np.arange(-math.ceil(radius_px) - 1.0, math.ceil(radius_px) + 2.0)
    height, width = view.excess.shape
    for back_px in MIDLINE_PX:
        back = np.arange(-float(back_px), -2.0)[:, None]
        x = np.rint(tip[0] + back * direction[0] - side * direction[1]).astype(np.intp)
        y = np.rint(tip[1] + back * direction[1] + side * direction[0]).astype(np.intp)
        inside = (x >= 0) & (x < width) & (y >= 0) & (y < height)
        x, y = np.clip(x, 0, width - 1), np.clip(y, 0, height - 1)
        seen = inside & finger[y, x] & (view.measured[y, x] > 0.0)
        read = np.where(seen, view.excess[y, x], np.inf)
        crest = seen & (read <= read.min(axis=1)[:, None] + CREST_MM)
        count = crest.sum(axis=1)
        rows = count >= LEAST_PX
        if np.count_nonzero(rows) < LEAST_ROWS:
            break
        slope, middle = _line(back[rows, 0], (crest[rows] @ side) / count[rows])
        slope = min(max(slope, -TURN), TURN)
        tip = _moved(tip, direction, 0.0, middle)
        length = math.hypot(1.0, slope)
        direction = (
            (direction[0] - slope * direction[1]) / length,
            (direction[1] + slope * direction[0]) / length,
        )
    return tip, direction


def _end(view: _View, tip: Pixel, direction: Pixel, radius_px: float) -> tuple[float, bool]:
    """Return how far ahead of `tip` the finger ends, px, and whether there is an edge."""
    half = math.floor(ROUND * radius_px)
    across = np.arange(-half, half + 1.0)
    # Bent like the end itself, so that the edge lies at one place in all columns.
    bend = radius_px - np.sqrt(radius_px**2 - across**2)
    along = AHEAD[:, None] - bend
    profile = _profile(view, tip, direction, along, np.broadcast_to(across, along.shape), 1)
    return (0.0, False) if profile is None else _edge(profile, AHEAD, END_PX)


def _sides(view: _View, tip: Pixel, direction: Pixel, radius_px: float) -> tuple[float, float]:
    """Return how far beside `tip` the finger's middle is, and its width, px; 0 and nan if unclear.

    Read where the tip is widest and a little behind.
    """
    back = np.arange(-math.ceil(2.0 * radius_px), -math.floor(0.7 * radius_px))
    along, across = np.meshgrid(back.astype(np.float64), ACROSS, indexing="ij")
    profile = _profile(view, tip, direction, along, across, 0)
    if profile is None:
        return 0.0, math.nan
    right, right_clear = _edge(profile, ACROSS, SIDE_PX)
    left, left_clear = _edge(profile[::-1], ACROSS, SIDE_PX)
    if not (left_clear and right_clear):
        return 0.0, math.nan
    return min(max((right - left) / 2.0, -OFF_PX), OFF_PX), right + left


def _profile(
    view: _View, tip: Pixel, direction: Pixel, along: Floats, across: Floats, axis: int
) -> Floats | None:
    """Average the excess over one direction, by what was measured; gaps are bridged."""
    total = straight(view.excess, tip, direction, along, across).sum(axis=axis)
    weight = straight(view.measured, tip, direction, along, across).sum(axis=axis)
    seen = weight > 0.15 * along.shape[axis]
    if np.count_nonzero(seen) < LEAST_ROWS:
        return None
    at = np.arange(len(total), dtype=np.float64)
    return np.interp(at, at[seen], total[seen] / weight[seen])


def _edge(profile: Floats, at: Floats, within: tuple[float, float]) -> tuple[float, bool]:
    """Return where a profile rises most, half way up the step, and whether that is an edge."""
    rise = np.full(len(profile), -np.inf)
    rise[2:-2] = profile[3:-1] + profile[4:] - profile[:-4] - profile[1:-3]
    rise[(at < within[0]) | (at > within[1])] = -np.inf
    k = min(max(int(np.argmax(rise)), 3), len(profile) - 4)
    low = 0.5 * (profile[k - 3] + profile[k - 2])
    high = 0.5 * (profile[k + 2] + profile[k + 3])
    half = 0.5 * (low + high)
    for j in (k - 1, k, k - 2, k + 1):
        if profile[j] < half <= profile[j + 1]:
            share = (half - profile[j]) / (profile[j + 1] - profile[j])
            return float(at[j] + share), bool(high - low > LEAST_STEP_MM)
    return float(at[k]), False


def _line(x: Floats, y: Floats) -> tuple[float, float]:
    """Return slope and offset at 0 of the line through points."""
    dx = x - x.mean()
    slope = float(dx @ y / (dx @ dx))
    return slope, float(y.mean()) - slope * float(x.mean())


def _moved(point: Pixel, direction: Pixel, along: float, across: float) -> Pixel:
    return (
        point[0] + along * direction[0] - across * direction[1],
        point[1] + along * direction[1] + across * direction[0],
    )
