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
from halo_service.sensing.finger_frame import FingerFrame, grid, nearest
from halo_service.sensing.segmentation import Segmentation

REACH_MM = 52.0
"""Half the window around a tip: a flat finger's last two segments (`ridge`)."""
FINGER_MM = 34.0
"""Length of a finger's line back from its tip, for the labels (chosen)."""
RISE_MM = 20.0
"""A fingertip's upper side rises by less in a frame (chosen: people lift at 0.4 m/s)."""
TIP_MM = 8.0
"""The height is checked only so far behind the tip: farther back a finger is high itself."""
NO_FINGER = 255
FAR = np.float32(1e9)
STRIP_MM = 6.0
"""Half the breadth of the strip for the search of a finger's end."""
LEAST_MM2 = 20.0
"""Less hand in it is noise."""
BEHIND = grid(-np.arange(8, 22, 3), np.arange(-14, 15))
"""Where a finger's breadth is measured: behind the tip, because a strong halo hides its end, and
wider than it is."""
NAIL = grid(-np.arange(8), np.arange(-7, 8))
"""The end of a finger, where its upper side is read."""
BREADTH_MM = (4.0, 24.0)
"""Of a finger: 12 to 18 mm, blurred; a fist's end is broader (chosen with a margin)."""

FingerNumbers = NDArray[np.uint8]


@dataclass(frozen=True, slots=True)
class Prediction:
    """A track's predicted place in the present frame."""

    place: FingerFrame
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
    boxes = [window(each.place, shape) for each in places]
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
    places = [segmentation.within(finger.place) for finger in fingers]
    boxes = [window(place, shape) for place in places]
    for number, (place, box) in enumerate(zip(places, boxes, strict=True)):
        if sum(_meet(box, other) for other in boxes) == 1:  # itself
            halo[box] = hand[box] = number
            continue
        ahead, aside = place.away_mm(*_pixels(box))
        back, aside = -ahead, aside**2
        for numbers, away, from_mm in ((halo, halo_away, 0.0), (hand, hand_away, TIP_MM)):
            off = back - np.clip(back, np.float32(from_mm), np.float32(FINGER_MM))
            own = aside + off * off
            nearer = own < away[box]
            np.copyto(away[box], own, where=nearer)
            np.copyto(numbers[box], np.uint8(number), where=nearer)
    return Labels(halo, hand)


def pixels_of(
    segmentation: Segmentation, labels: Labels, number: int, place: Prediction
) -> Segmentation:
    """Return the scene around a place, without the pixels of other fingers."""
    there = segmentation.within(place.place)
    box = window(there, segmentation.hand.shape)
    around = segmentation.cut(box)
    open_to_it = _open(labels.halo[box], number)
    hand = around.hand & _open(labels.hand[box], number)
    if not math.isnan(place.top_mm):
        ahead, _ = there.away_mm(*_pixels(box))
        high = around.excess_mm < -(place.top_mm + RISE_MM)
        hand &= ~(high & (ahead > -TIP_MM))
    share = (hand | ~around.hand).astype(np.float32)
    return replace(
        around, halo=around.halo & open_to_it, hand=hand, free=around.free & open_to_it, share=share
    )


def strip_end(segmentation: Segmentation, place: FingerFrame) -> FingerFrame:
    """Return the end of the strip of hand along a finger's line, the predicted tip without one.

    It finds a tip that moved farther along the finger than predicted.
    """
    rows, columns = np.nonzero(segmentation.hand)
    there = segmentation.within(place)
    along, across = there.away_mm(columns.astype(np.float32), rows.astype(np.float32))
    along = along[np.abs(across) <= STRIP_MM]
    least = max(round(LEAST_MM2 * place.px_per_mm**2), 1)
    if along.size < least:
        return place
    return place.moved(float(np.partition(along, -least)[-least]))


def is_finger(segmentation: Segmentation, place: FingerFrame) -> bool:
    """Return whether the shape that ends at a tip is as broad as a finger.

    What is hidden can belong to it.
    """
    there = segmentation.within(place)
    shown_mm = _breadth_mm(segmentation.hand, there)
    hidden_mm = 0.0 if segmentation.hidden is None else _breadth_mm(segmentation.hidden, there)
    return BREADTH_MM[0] <= shown_mm + hidden_mm and shown_mm <= BREADTH_MM[1]


def is_hidden(segmentation: Segmentation, place: FingerFrame) -> bool:
    """Return whether another finger is above a part of a fingertip."""
    hidden = segmentation.hidden
    if hidden is None:
        return False
    seen = nearest(hidden.view(np.uint8), segmentation.within(place), NAIL, 0.0)
    return bool(seen.any())


def _breadth_mm(mask: NDArray[np.bool_], place: FingerFrame) -> float:
    seen = nearest(mask.view(np.uint8), place, BEHIND, 0.0)
    return float(np.median(np.count_nonzero(seen, axis=1)))


def _open(numbers: FingerNumbers, number: int) -> NDArray[np.bool_]:
    return np.asarray((numbers == number) | (numbers == NO_FINGER))


def window(place: FingerFrame, shape: tuple[int, ...], reach_mm: float = REACH_MM) -> Part:
    """Return the part of an image, (H, W), within so many mm to each side of a tip."""
    (column, row), reach = (round(each) for each in place.tip_px), round(reach_mm * place.px_per_mm)
    rows = slice(min(max(row - reach, 0), shape[0]), min(max(row + reach, 0), shape[0]))
    columns = slice(min(max(column - reach, 0), shape[1]), min(max(column + reach, 0), shape[1]))
    return rows, columns


def _meet(a: Part, b: Part) -> bool:
    return all(p.start < q.stop and q.start < p.stop for p, q in zip(a, b, strict=True))


def _pixels(box: Part) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Return x, (1, w), and y, (h, 1), of a box's pixels."""
    x = np.arange(box[1].start, box[1].stop, dtype=np.float32)
    y = np.arange(box[0].start, box[0].stop, dtype=np.float32)
    return x[None, :], y[:, None]
