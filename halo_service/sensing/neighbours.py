"""Leave out the other fingers of the same hand: by the hand's bones, and by the steps between them.

A neighbour that hangs next to a fingertip is higher and clearer: its outline would pass for the
fingertip's. The hand model often places the last joints of one finger on the other, but the first
ones are right, and between two fingers at different heights the depth has a step. A watershed that
starts from the first joints follows it. What hangs over a finger hides it: there is neither finger
nor surface there, but nothing known.
"""

from __future__ import annotations

import math
from dataclasses import replace

import cv2
import numpy as np
from numpy.typing import NDArray

from halo_service.sensing.detections import FINGER_MARKS, THUMB_TIP, Detection
from halo_service.sensing.finger_frame import FingerFrame, Pixel
from halo_service.sensing.segmentation import Segmentation
from halo_service.values import Finger

CLEARLY = 0.8
"""A pixel of the hand is a finger's if its bones are nearer than another's by this share: at the
border between two fingers the landmarks' errors decide (chosen)."""
BONES_MM = 2.0
"""A pixel that is nearer to a finger's bones than to another's by this much is its own with
probability 0.73 (chosen: landmarks are 2 mm off across a finger)."""
AHEAD_MM = 12.0
"""A finger's halo reaches so far beyond its tip."""
FIRST_BONES = 1.5
"""Of a finger, from its knuckle, on which the landmarks are right (chosen: beyond, they are on the
neighbour in one frame of six at the worst user)."""
BEYOND_STEP = 0.1
"""Factor for the probability of a pixel beyond a step."""
STEP_MM = 8.0
"""What is higher than a finger by this hides it (chosen: half a finger)."""
HIDES_MM = 14.0
"""A neighbour hides a finger up to its breadth from what shows of it."""
LOWEST_MM, PER_MM = -10.0, 2.0
"""Heights in the watershed's image: from the lowest one, in halves of a millimetre."""
OWN, OTHER, SURFACE = 1, 2, 3
FAR_PX = 1e4
"""Beyond any image: OpenCV draws with 16 bits."""
UNSEEN_MM = np.float32(-1e3)

Mask = NDArray[np.bool_]
Bones = NDArray[np.float64]


def without_others(
    segmentation: Segmentation,
    detection: Detection,
    moved_px: Pixel = (0.0, 0.0),
    place: FingerFrame | None = None,
) -> Segmentation:
    """Return the scene without the pixels of the other fingers of a detected finger's hand.

    `moved_px`: how far the finger went since its detection; `place`: where its track expects it,
    which is right where the model sees the finger folded.
    """
    shape = segmentation.hand.shape
    if segmentation.hand.size == 0:
        return segmentation
    own, others = _bones(segmentation, detection, moved_px)
    ahead = own[-1] + (own[-1] - own[-2]) * AHEAD_MM * detection.px_per_mm / max(
        math.dist(own[-1], own[-2]), 1.0
    )
    lines = [(*own, ahead)]
    if place is not None:
        there = segmentation.within(place)
        expected = own[1], there.tip_px, there.moved(AHEAD_MM).tip_px
        lines.append((*expected, expected[-1], expected[-1]))  # as many points as the other
    own_away, others_away = _away(np.array(lines), shape), _away(others, shape)
    mine = own_away <= others_away
    clearly_mine = own_away <= CLEARLY * others_away
    nearer = (others_away - own_away) / np.float32(BONES_MM * detection.px_per_mm)
    share = 1.0 / (1.0 + np.exp(-np.clip(nearer, -20.0, 20.0)))
    if segmentation.share is not None:
        share *= segmentation.share
    labels = _by_steps(segmentation, own, others)
    beyond = labels == OTHER
    share[beyond] *= np.float32(BEYOND_STEP)
    shown = ~_hidden(segmentation, labels, detection.px_per_mm)
    return replace(
        segmentation,
        excess_mm=segmentation.excess_mm * shown,
        halo=segmentation.halo & mine & shown,
        hand=segmentation.hand & clearly_mine & shown & ~beyond,
        free=segmentation.free & mine & shown,
        solid=segmentation.solid & shown,
        share=share,
        hidden=~shown,
    )


def _bones(
    segmentation: Segmentation, detection: Detection, moved_px: Pixel
) -> tuple[Bones, Bones]:
    """Return the joints of the detected finger, (4, 2), and those of the others, (4, 4, 2)."""
    left, top = segmentation.left - moved_px[0], segmentation.top - moved_px[1]
    marks = detection.hand_px - (left, top)
    fingers = marks[THUMB_TIP - FINGER_MARKS + 1 :].reshape(len(Finger), FINGER_MARKS, 2)
    own = int(detection.finger)
    return fingers[own], np.delete(fingers, own, axis=0)


def _away(lines: Bones, shape: tuple[int, ...]) -> NDArray[np.float32]:
    """Return how far each pixel is from the nearest of some lines, (lines, points, 2); px."""
    off = ~_drawn(lines, shape)
    return np.asarray(cv2.distanceTransform(off.view(np.uint8), cv2.DIST_L2, 3), np.float32)


def _drawn(lines: Bones, shape: tuple[int, ...]) -> Mask:
    canvas = np.zeros(shape, np.uint8)
    points = np.rint(np.clip(lines, -FAR_PX, FAR_PX) * 16.0).astype(np.int32)
    cv2.polylines(canvas, tuple(points), False, (1,), shift=4)
    return canvas.view(np.bool_)


def _by_steps(segmentation: Segmentation, own: Bones, others: Bones) -> NDArray[np.int32]:
    """Return the label of each pixel: `OWN`, `OTHER`, `SURFACE`, or -1 at a border."""
    shape = segmentation.hand.shape
    mine = _drawn(_first(own)[None], shape)
    theirs = _drawn(_first(others), shape)
    labels = segmentation.free * np.int32(SURFACE)
    labels[mine & ~theirs] = OWN
    labels[theirs & ~mine] = OTHER
    heights = (-segmentation.excess_mm - np.float32(LOWEST_MM)) * np.float32(PER_MM)
    image = np.clip(heights, 0.0, 255.0).astype(np.uint8)
    return np.asarray(cv2.watershed(cv2.merge([image] * 3), labels), np.int32)


def _first(joints: Bones) -> Bones:
    """Return the part of fingers' bones, (..., 4, 2), on which their landmarks are right."""
    whole, share = divmod(FIRST_BONES, 1.0)
    first = joints[..., : int(whole) + 2, :].copy()
    first[..., -1, :] = first[..., -2, :] + share * (first[..., -1, :] - first[..., -2, :])
    return first


def _hidden(segmentation: Segmentation, labels: NDArray[np.int32], px_per_mm: float) -> Mask:
    """Return where a neighbour is higher than what shows of the finger next to it."""
    height_mm = -segmentation.excess_mm
    own_mm = np.where(labels == OWN, height_mm, UNSEEN_MM)
    reach = 2 * round(HIDES_MM * px_per_mm) + 1
    near_mm = np.asarray(cv2.dilate(own_mm, np.ones((reach, reach), np.uint8)))
    hides = (labels == OTHER) & (near_mm > UNSEEN_MM) & (height_mm > near_mm + STEP_MM)
    # A pixel at a step is a mixture of both sides.
    mixed = cv2.dilate(hides.view(np.uint8), np.ones((3, 3), np.uint8)).view(np.bool_)
    return np.asarray(mixed & (labels != OWN))
