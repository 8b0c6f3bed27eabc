"""Label pixels: which part of hand and halo belongs to one finger when others are near.

A silhouette holds all fingers at once, and the halos of neighbours merge. Each pixel belongs to the
nearest finger; what is much higher than the fingertip just was is another part of the hand.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from halo_service.sensing.background import Part
from halo_service.sensing.detections import Pixel
from halo_service.sensing.segmentation import Segmentation

REACH_PX = 52
"""Half the window around a tip: a flat finger's last two segments (`ridge`)."""
FINGER_PX = 34.0
"""Length of a finger's line back from its tip, for the labels (chosen: 3.4 cm)."""
RISE_MM = 20.0
"""A fingertip's upper side rises by less in a frame (chosen: people lift at 0.4 m/s)."""
TIP_PX = 8.0
"""The height is checked only so far behind the tip: farther back a finger is high itself."""
NO_FINGER = 255
FAR = np.float32(1e9)
STRIP_PX = 6.0
"""Half the breadth of the strip for the search of a finger's end."""
LEAST_PX = 20
"""Fewer pixels are noise."""
BACK_PX = np.arange(8.0, 22.0, 3.0)
ACROSS_PX = np.arange(-14.0, 15.0)
"""Where a finger's breadth is measured: behind the tip, because a strong halo hides its end, and
wider than it is."""
BREADTH_PX = (4.0, 24.0)
"""Of a finger at 0.5 m: 12 to 18 mm, blurred; a fist's end is broader (chosen with a margin)."""

FingerNumbers = NDArray[np.uint8]


@dataclass(frozen=True, slots=True)
class Prediction:
    """A track's predicted place in the present frame."""

    tip_px: Pixel
    direction: Pixel
    """Unit vector from joint to tip."""
    top_mm: float
    """Height of its upper side when it was last seen; nan where unknown."""


@dataclass(frozen=True, slots=True, eq=False)
class Labels:
    """The label of each pixel: the finger's number, or `NO_FINGER`."""

    halo: FingerNumbers
    """(h, w) by the distance to a finger's line from its tip on."""
    hand: FingerNumbers
    """(h, w) by the distance to the line from a little behind the tip: skin beyond a tip belongs to
    the neighbour rather than to a finger that was predicted too far out."""


def around(places: Sequence[Prediction], shape: tuple[int, ...]) -> Part:
    """Return the part of an image, (H, W), with the windows of all these places."""
    boxes = [_box(place.tip_px, shape) for place in places]
    return (
        slice(
            min((y.start for y, _ in boxes), default=0), max((y.stop for y, _ in boxes), default=0)
        ),
        slice(
            min((x.start for _, x in boxes), default=0), max((x.stop for _, x in boxes), default=0)
        ),
    )


def label_pixels(fingers: Sequence[Prediction], segmentation: Segmentation) -> Labels:
    """Label each pixel around the fingers with the nearest of them."""
    shape = segmentation.hand.shape
    halo, hand = np.full(shape, NO_FINGER, np.uint8), np.full(shape, NO_FINGER, np.uint8)
    if len(fingers) < 2:
        return Labels(halo, hand)
    halo_away, hand_away = np.full(shape, FAR, np.float32), np.full(shape, FAR, np.float32)
    tips = [segmentation.inside(finger.tip_px) for finger in fingers]
    boxes = [_box(tip, shape) for tip in tips]
    for number, (finger, tip, box) in enumerate(zip(fingers, tips, boxes, strict=True)):
        if sum(_meet(box, other) for other in boxes) == 1:  # itself
            halo[box] = hand[box] = number
            continue
        dx, dy = _from(tip, box)
        ux, uy = np.float32(finger.direction[0]), np.float32(finger.direction[1])
        back, aside = -dx * ux - dy * uy, (dy * ux - dx * uy) ** 2
        for numbers, away, from_px in ((halo, halo_away, 0.0), (hand, hand_away, TIP_PX)):
            off = back - np.clip(back, np.float32(from_px), np.float32(FINGER_PX))
            own = aside + off * off
            nearer = own < away[box]
            np.copyto(away[box], own, where=nearer)
            np.copyto(numbers[box], np.uint8(number), where=nearer)
    return Labels(halo, hand)


def pixels_of(
    segmentation: Segmentation, labels: Labels, number: int, place: Prediction
) -> Segmentation:
    """Return the scene around a place, without the pixels of other fingers."""
    tip = segmentation.inside(place.tip_px)
    box = _box(tip, segmentation.hand.shape)
    around = segmentation.cut(box)
    open_to_it = _open(labels.halo[box], number)
    hand = around.hand & _open(labels.hand[box], number)
    if not math.isnan(place.top_mm):
        dx, dy = _from(tip, box)
        ahead = dx * np.float32(place.direction[0]) + dy * np.float32(place.direction[1])
        high = around.excess_mm < -(place.top_mm + RISE_MM)
        hand &= ~(high & (ahead > -TIP_PX))
    return replace(around, halo=around.halo & open_to_it, hand=hand, free=around.free & open_to_it)


def strip_end(segmentation: Segmentation, place: Prediction) -> Pixel:
    """Return the end of the strip of hand along a finger's line, the predicted tip without one.

    It finds a tip that moved farther along the finger than predicted.
    """
    rows, columns = np.nonzero(segmentation.hand)
    x, y = segmentation.inside(place.tip_px)
    dx, dy = columns - x, rows - y
    ux, uy = place.direction
    along = (dx * ux + dy * uy)[np.abs(dy * ux - dx * uy) <= STRIP_PX]
    if along.size < LEAST_PX:
        return place.tip_px
    end = float(np.partition(along, -LEAST_PX)[-LEAST_PX])
    return place.tip_px[0] + end * ux, place.tip_px[1] + end * uy


def is_finger(segmentation: Segmentation, tip_px: Pixel, direction: Pixel) -> bool:
    """Return whether the shape that ends at a tip is as broad as a finger.

    `direction`: unit vector from joint to tip.
    """
    tip, hand, (dx, dy) = segmentation.inside(tip_px), segmentation.hand, direction
    x = np.rint(tip[0] - BACK_PX[:, None] * dx - ACROSS_PX * dy).astype(np.intp)
    y = np.rint(tip[1] - BACK_PX[:, None] * dy + ACROSS_PX * dx).astype(np.intp)
    height, width = hand.shape
    inside = (x >= 0) & (x < width) & (y >= 0) & (y < height)
    seen = hand[np.clip(y, 0, height - 1), np.clip(x, 0, width - 1)] & inside
    breadth = float(np.median(np.count_nonzero(seen, axis=1)))
    return BREADTH_PX[0] <= breadth <= BREADTH_PX[1]


def _open(numbers: FingerNumbers, number: int) -> NDArray[np.bool_]:
    return np.asarray((numbers == number) | (numbers == NO_FINGER))


def _box(tip: Pixel, shape: tuple[int, ...]) -> Part:
    column, row = round(tip[0]), round(tip[1])
    rows = slice(min(max(row - REACH_PX, 0), shape[0]), min(max(row + REACH_PX, 0), shape[0]))
    columns = slice(
        min(max(column - REACH_PX, 0), shape[1]), min(max(column + REACH_PX, 0), shape[1])
    )
    return rows, columns


def _meet(a: Part, b: Part) -> bool:
    return all(p.start < q.stop and q.start < p.stop for p, q in zip(a, b, strict=True))


def _from(tip: Pixel, box: Part) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Return x, (1, w), and y, (h, 1), of a box's pixels from a tip, px."""
    x = np.arange(box[1].start, box[1].stop, dtype=np.float32) - np.float32(tip[0])
    y = np.arange(box[0].start, box[0].stop, dtype=np.float32) - np.float32(tip[1])
    return x[None, :], y[:, None]
