"""Fingertip detections: those of each hand once."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from halo_service.sensing.finger_frame import Pixel
from halo_service.sensing.scale import Scale
from halo_service.values import Finger, Hand, Side, Tracked

Fingers = Literal["index", "all"]

WRIST = 0
THUMB_TIP = 4
FINGER_MARKS = 4
"""MediaPipe's landmarks: the wrist, then four a finger, from the thumb's root to the little tip."""
PALM = (0, 5, 9, 13, 17)
"""Wrist and knuckles."""
SAME_PALM_MM = 30.0
"""Two palms nearer to each other than this are one hand, seen twice (chosen: half a palm)."""
LEAST_SPREAD_MM = 25.0
"""A smaller spread of landmarks is not a hand (chosen: a fist spans three times that)."""
FARTHEST_PX = 1e5
"""A landmark farther from the image's origin is invalid (chosen: wider than any image)."""


@dataclass(frozen=True, slots=True, eq=False)
class Detection:
    """One finger in the tracker's frame."""

    time_us: int
    side: Side
    finger: Finger
    tip_px: Pixel
    distal_px: Pixel
    """The joint next to the tip, moved to the line to the finger's root: a finger bends in one
    plane, and two landmarks 20 px apart give a poor direction."""
    confidence: float
    px_per_mm: float
    """At the depth that the present frame shows there."""
    extended: bool
    """Whether the landmarks show it stretched out. A finger that points at the camera or away from
    it often looks bent, so this starts a track, but its lack ends none."""
    hand_px: NDArray[np.float64]
    """(21, 2) the landmarks of its hand."""
    on_surface: float
    """Pixels a millimetre on the surface."""

    @property
    def place_mm(self) -> Pixel:
        """The tip in millimetres of the surface, along the image's rows and columns."""
        return self.tip_px[0] / self.on_surface, self.tip_px[1] / self.on_surface


def detections(
    tracked: Tracked | None, scale: Scale, wanted: Fingers = "index"
) -> tuple[Detection, ...]:
    """Return the fingers of the tracked hands, the most confident hand first."""
    if tracked is None:
        return ()
    fingers = tuple(Finger) if wanted == "all" else (Finger.INDEX,)
    return tuple(
        _detection(tracked.time_us, hand, finger, scale)
        for hand in each_once(tracked.hands, scale)
        for finger in fingers
    )


def each_once(hands: tuple[Hand, ...], scale: Scale) -> tuple[Hand, ...]:
    """Remove what is not a hand, and a hand's second detection; the most confident hand first."""
    kept: list[tuple[Hand, Pixel]] = []
    for hand in sorted(hands, key=lambda hand: -hand.confidence):
        marks = hand.landmarks_px
        if not (np.abs(marks) < FARTHEST_PX).all():  # true for nan
            continue
        palm = _pixel(marks[list(PALM)].mean(axis=0))
        px_per_mm = scale.px_per_mm(palm)
        spans = float(np.ptp(marks, axis=0).max()) >= LEAST_SPREAD_MM * px_per_mm
        apart_px = SAME_PALM_MM * px_per_mm
        if spans and all(math.dist(palm, other) >= apart_px for _, other in kept):
            kept.append((hand, palm))
    return tuple(hand for hand, _ in kept)


def _detection(time_us: int, hand: Hand, finger: Finger, scale: Scale) -> Detection:
    tip = THUMB_TIP + FINGER_MARKS * int(finger)
    outermost = _outermost(hand, finger)
    end, before, root = hand.landmarks_px[[outermost, outermost - 1, tip - FINGER_MARKS + 1]]
    line = (end - root) / max(float(np.linalg.norm(end - root)), 1.0)
    joint = end - line * float(np.linalg.norm(end - before))
    return Detection(
        time_us,
        hand.side,
        finger,
        _pixel(end),
        _pixel(joint),
        hand.confidence,
        scale.px_per_mm(_pixel(joint)),
        outermost > tip - 2,
        hand.landmarks_px,
        scale.on_surface,
    )


def _outermost(hand: Hand, finger: Finger) -> int:
    """Return the landmark of a finger that is farthest from the wrist: an extended finger's tip.

    Where the camera looks along a finger, the model may see it folded, and its tip far back; the
    joint that it sees farthest out is then nearest to the real tip. A thumb folds across the palm:
    there it is the farthest from the little finger's knuckle.
    """
    tip = THUMB_TIP + FINGER_MARKS * int(finger)
    away = hand.landmarks_px[PALM[-1] if finger is Finger.THUMB else WRIST]
    joints = hand.landmarks_px[tip - 2 : tip + 1] - away
    return tip - 2 + int(np.argmax(np.hypot(joints[:, 0], joints[:, 1])))


def _pixel(point: NDArray[np.float64]) -> Pixel:
    return float(point[0]), float(point[1])
