"""Label pixels: which part of hand and halo belongs to one finger when others are near.

A silhouette holds all fingers at once, and the halos of neighbours merge. Each pixel belongs to the
nearest finger; what is much higher than the fingertip just was is another part of the hand.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import cv2
import numpy as np
from numpy.typing import NDArray

from halo_service.sensing.background import Part
from halo_service.sensing.detections import FINGER_MARKS, THUMB_TIP, Detection
from halo_service.sensing.finger_frame import FingerFrame, Pixel, grid, nearest
from halo_service.sensing.segmentation import Segmentation
from halo_service.values import Finger

REACH_MM = 52.0
"""Half the window around a tip: a flat finger's last two segments (`ridge`)."""
FINGER_MM = 34.0
"""Length of a finger's line back from its tip, for the labels (chosen)."""
RISE_MM = 20.0
"""A fingertip's upper side rises by less in a frame (chosen: people lift at 0.4 m/s)."""
TIP_MM = 8.0
"""The height is checked only so far behind the tip: farther back a finger is high itself."""
CLEARLY = 0.8
"""A pixel of the hand is a finger's if its bones are nearer than another's by this share: at the
border between two fingers the landmarks' errors decide (chosen)."""
BONES_MM = 2.0
"""A pixel that is nearer to a finger's bones than to another's by this much is its own with
probability 0.73 (chosen: landmarks are 2 mm off across a finger)."""
AHEAD_MM = 12.0
"""A finger's halo reaches so far beyond its tip."""
NO_FINGER = 255
FAR = np.float32(1e9)
FAR_PX = 1e4
"""Beyond any image: OpenCV draws with 16 bits."""
STRIP_MM = 6.0
"""Half the breadth of the strip for the search of a finger's end."""
LEAST_MM2 = 20.0
"""Less hand in it is noise."""
BEHIND = grid(-np.arange(8, 22, 3), np.arange(-14, 15))
"""Where a finger's breadth is measured: behind the tip, because a strong halo hides its end, and
wider than it is."""
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
    boxes = [_box(each.place, shape) for each in places]
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
    boxes = [_box(place, shape) for place in places]
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
    box = _box(there, segmentation.hand.shape)
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


def without_others(
    segmentation: Segmentation, detection: Detection, moved_px: Pixel = (0.0, 0.0)
) -> Segmentation:
    """Return the scene without the pixels that are nearer to another finger of the same hand.

    By the bones between the landmarks, `moved_px` since they were detected. A neighbour that hangs
    next to a fingertip is higher and clearer: its outline would pass for the fingertip's.
    """
    shape = segmentation.hand.shape
    if segmentation.hand.size == 0:
        return segmentation
    left, top = segmentation.left - moved_px[0], segmentation.top - moved_px[1]
    marks = detection.hand_px - (left, top)
    ends = THUMB_TIP + FINGER_MARKS * np.arange(len(Finger))
    fingers = [marks[end - FINGER_MARKS + 1 : end + 1] for end in ends]
    own = fingers.pop(int(detection.finger))
    ahead = own[-1] + (own[-1] - own[-2]) * AHEAD_MM * detection.px_per_mm / max(
        math.dist(own[-1], own[-2]), 1.0
    )
    away = [_away(lines, shape) for lines in ([np.vstack([own, ahead])], fingers)]
    mine = away[0] <= away[1]
    clearly_mine = away[0] <= CLEARLY * away[1]
    nearer = (away[1] - away[0]) / np.float32(BONES_MM * detection.px_per_mm)
    share = 1.0 / (1.0 + np.exp(-np.clip(nearer, -20.0, 20.0)))
    if segmentation.share is not None:
        share *= segmentation.share
    return replace(
        segmentation,
        halo=segmentation.halo & mine,
        hand=segmentation.hand & clearly_mine,
        free=segmentation.free & mine,
        share=share,
    )


def _away(lines: Sequence[NDArray[np.float64]], shape: tuple[int, ...]) -> NDArray[np.float32]:
    """Return how far each pixel is from the nearest of some lines, px."""
    canvas = np.ones(shape, np.uint8)
    points = [np.rint(np.clip(line, -FAR_PX, FAR_PX) * 16.0).astype(np.int32) for line in lines]
    cv2.polylines(canvas, points, False, (0,), shift=4)
    return np.asarray(cv2.distanceTransform(canvas, cv2.DIST_L2, 3), np.float32)


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
    """Return whether the shape that ends at a tip is as broad as a finger."""
    hand = segmentation.hand.astype(np.float32)
    seen = nearest(hand, segmentation.within(place), BEHIND, 0.0)
    breadth = float(np.median(np.count_nonzero(seen, axis=1)))
    return BREADTH_MM[0] <= breadth <= BREADTH_MM[1]


def _open(numbers: FingerNumbers, number: int) -> NDArray[np.bool_]:
    return np.asarray((numbers == number) | (numbers == NO_FINGER))


def _box(place: FingerFrame, shape: tuple[int, ...]) -> Part:
    (column, row), reach = (round(each) for each in place.tip_px), round(REACH_MM * place.px_per_mm)
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
