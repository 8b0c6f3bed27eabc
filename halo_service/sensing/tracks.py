"""One track for each finger: its state from frame to frame, and its predicted place.

The hand tracker reports that there is a finger, which one, and roughly where. From then on the
depth image gives its place. The hand tracker loses a hand in every tenth frame, sees one twice, or
confuses left and right; a finger must keep its place, id and touch all the same.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from halo_service.sensing.debounce import Debounce
from halo_service.sensing.detections import Detection
from halo_service.sensing.detector import Detector
from halo_service.sensing.finger_frame import FingerFrame, Pixel, unit
from halo_service.sensing.label_pixels import Prediction
from halo_service.sensing.pointers import Motion
from halo_service.sensing.settings import SensingSettings
from halo_service.values import Fingertip, Pointer, Side, TouchEvent

LOWER_MM = 8.0
"""Of two possible places the fingertip is lower than a knuckle by this (chosen: half a finger's
thickness)."""
REMEMBERED = 8
"""Past tips per track: the slowest tracker's delay at 30 frames a second."""
CLAIM_US = 150_000
"""Greatest age of a detection that gives a finger's place (chosen: a slow tracker's delay)."""
BESIDE_MM = 12.0
"""The tracker's tips are rarely farther off; a neighbour's middle is 18 mm away (chosen)."""
INSISTS = 4
"""Detections in a row: tracker errors are single, or in runs when hands overlap (chosen)."""
MOVED_MM = 5.0
"""A tip that went this far has moved (chosen: more than its noise, less than a resting hand drifts
in a second or two)."""
LEFT_BEHIND_US, HELD_US = 2_000_000, 10_000_000
"""Without a detection and without motion for so long, a track is an object: a pen, a mug. A touch
lasts longer, because a pressing finger is still (chosen)."""
UNDETECTED_CONFIDENCE, ELSEWHERE_CONFIDENCE = 0.6, 0.6
"""Factors for a finger without a recent detection, and for one detected elsewhere."""
UNSHOWN_CONFIDENCE = 0.4
"""Factor for each frame that does not show the finger."""
GAP_FRAMES = 2.0
"""Over a gap in time a finger is predicted by at most this many of its last steps."""


@dataclass(frozen=True, slots=True)
class Past:
    """Where a tip was."""

    time_us: int
    tip_px: Pixel


@dataclass(frozen=True, slots=True)
class Track:
    """One finger, from its first detection until it is gone."""

    id: int
    slot: int
    detection: Detection
    """The last one."""
    direction: Pixel
    """Unit vector from joint to tip in the image, smoothed over the detections."""
    px_per_mm: float
    """At its depth, as it was last measured."""
    votes: int
    """For a right hand minus those for a left one, over the last detections."""
    shown_us: int
    """When the depth image last showed it."""
    off_path: int = 0
    """Detections in a row that are off its path."""
    contradicted: int = 0
    """Detections in a row that contradict its path."""
    pointer: Pointer | None = None
    """As last published; None for a new track."""
    path: tuple[Past, ...] = ()
    """Its tips, oldest first, at most `REMEMBERED`."""
    moved: Past | None = None
    """Where it was when it last moved."""
    detector: Detector | None = None
    debounce: Debounce = Debounce()  # noqa: RUF009 - frozen, so one default serves all
    motion: Motion = Motion()  # noqa: RUF009

    @property
    def side(self) -> Side:
        """Left or right, by majority."""
        return Side.UNKNOWN if self.votes == 0 else Side.RIGHT if self.votes > 0 else Side.LEFT


def predict(finger: Track, time_us: int) -> Prediction:
    """Return a finger's predicted place: by its own path, for a new track by its detection."""
    tip = finger.detection.tip_px
    if finger.path:
        tip = _moved(finger.path[-1].tip_px, _ahead(finger.path, time_us))
    top_mm = finger.pointer.diagnostics.top_mm if finger.path and finger.pointer else math.nan
    return Prediction(FingerFrame(tip, finger.direction, finger.px_per_mm), top_mm)


def claim(finger: Track, time_us: int) -> Prediction | None:
    """Return the detected place of a finger, None without a recent detection."""
    if not finger.path or time_us - finger.detection.time_us > CLAIM_US:
        return None
    tip, joint = finger.detection.tip_px, finger.detection.distal_px
    return Prediction(FingerFrame(tip, unit(joint, tip), finger.detection.px_per_mm), math.nan)


def is_there(finger: Track, claimed: Prediction, expected: Prediction, seen: Fingertip) -> bool:
    """Return whether a tip is at its detected place, or as far off as the finger moved since.

    A tip farther from that place is a knuckle or another finger.
    """
    then = (
        was_at(finger.path, finger.detection.time_us)
        if finger.path
        else Past(0, expected.place.tip_px)
    )
    went_px = math.dist(expected.place.tip_px, then.tip_px)
    beside_px = BESIDE_MM * finger.px_per_mm
    return math.dist(seen.tip_px, claimed.place.tip_px) < beside_px + went_px


def was_at(path: tuple[Past, ...], time_us: int) -> Past:
    """Return where a finger was at a time, or next to it."""
    return min(path, key=lambda past: abs(past.time_us - time_us))


def is_better(finger: Track, claimed: Fingertip, followed: Fingertip | None) -> bool:
    """Return whether the detected place is right rather than the one along the path.

    A fingertip is below the knuckles of its hand: the lower of two places is accepted at once, one
    as low after several detections, a higher one never.
    """
    if followed is None:
        return True
    lower_mm = LOWER_MM if finger.off_path < INSISTS else -LOWER_MM
    return claimed.top_mm < followed.top_mm - lower_mm


def detection_at(finger: Track, place: FingerFrame) -> Detection:
    """Return a finger's last detection, moved to its predicted place."""
    tip, joint = finger.detection.tip_px, finger.detection.distal_px
    back_mm = math.dist(tip, joint) / finger.detection.px_per_mm
    return replace(
        finger.detection,
        side=finger.side,
        tip_px=place.tip_px,
        distal_px=place.moved(-back_mm).tip_px,
        px_per_mm=place.px_per_mm,
    )


def along(finger: Track, now: Past, px_per_mm: float, followed: bool) -> Track:
    """Return a finger with its tip in the present frame; `followed`: found along its path."""
    moved = finger.moved
    if moved is None or math.dist(moved.tip_px, now.tip_px) > MOVED_MM * px_per_mm:
        moved = now
    path = (*(finger.path if followed else ()), now)[-REMEMBERED:]
    return replace(finger, path=path, moved=moved, px_per_mm=px_per_mm, shown_us=now.time_us)


def is_abandoned(finger: Track, time_us: int) -> bool:
    """Return whether a track is an object: it is still and has no detection."""
    if finger.moved is None:
        return False
    believed_us = HELD_US if finger.debounce.contact.touching else LEFT_BEHIND_US
    return time_us - max(finger.detection.time_us, finger.moved.time_us) > believed_us


def tracker_confidence(finger: Track, time_us: int) -> float:
    """Return the factor for a finger that the tracker does not confirm at its place."""
    if time_us - finger.detection.time_us > CLAIM_US:
        return UNDETECTED_CONFIDENCE
    return ELSEWHERE_CONFIDENCE if finger.contradicted else 1.0


def coast(finger: Track, time_us: int, settings: SensingSettings) -> Track | None:
    """Return the track for a frame that does not show the finger, or None after a while."""
    pointer = finger.pointer
    if pointer is None or time_us - finger.shown_us > 1000.0 * settings.lost_after_ms:
        return None
    unsure = pointer.confidence * UNSHOWN_CONFIDENCE
    return replace(finger, pointer=replace(pointer, vx_mm_s=0.0, vy_mm_s=0.0, confidence=unsure))


def _ahead(path: tuple[Past, ...], time_us: int) -> Pixel:
    """Return how far a tip moves from its last place at its last speed, px."""
    last, before = path[-1], path[max(len(path) - 2, 0)]
    steps = (time_us - last.time_us) / max(last.time_us - before.time_us, 1)
    steps = min(steps, GAP_FRAMES) if len(path) > 1 else 0.0
    return steps * (last.tip_px[0] - before.tip_px[0]), steps * (last.tip_px[1] - before.tip_px[1])


def _moved(place: Pixel, by: Pixel) -> Pixel:
    return place[0] + by[0], place[1] + by[1]


def changes(before: Track, now: Track | None) -> tuple[TouchEvent, ...]:
    """Return the event between two frames of one finger: at most one.

    A finger that is lost (`now` is None) in a touch still gets its up.
    """
    touched = before.debounce.contact.touching
    touching = now is not None and now.debounce.contact.touching
    after = now or before
    pointer = after.pointer
    if touched == touching or pointer is None:
        return ()
    return (
        TouchEvent(
            kind="down" if touching else "up",
            id=after.id,
            slot=after.slot,
            x_mm=pointer.x_mm,
            y_mm=pointer.y_mm,
            strike_mm_s=_strike(before, now) if now and touching else 0.0,
            ago_ms=after.debounce.contact.ago_us / 1000.0 if now else 0.0,
            contacts=pointer.contacts,
        ),
    )


def _strike(before: Track, now: Track) -> float:
    return before.motion.strike_mm_s(now.shown_us - now.debounce.contact.ago_us)
