"""One track for each finger: its state from frame to frame, and its predicted place.

The hand tracker reports that there is a finger, which one, and roughly where, some frames late.
From then on the depth image gives its place. The hand tracker loses a hand in every tenth frame,
sees one twice, or confuses left and right; a finger must keep its place, id and touch all the same.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from enum import Enum, auto

from halo_service.sensing.debounce import Debounce
from halo_service.sensing.detections import Detection
from halo_service.sensing.detector import Detector
from halo_service.sensing.finger_frame import FingerFrame, Pixel, unit
from halo_service.sensing.kalman import (
    LONGEST_S,
    Kalman,
    Place,
    born,
    carried,
    corrected,
    predicted,
)
from halo_service.sensing.label_pixels import Prediction
from halo_service.sensing.pointers import Motion
from halo_service.sensing.registration import REMEMBERED, HeightMap, shift_px
from halo_service.sensing.settings import SensingSettings
from halo_service.values import Fingertip, Pointer, Side, TouchEvent

LANDMARK_MM, TIP_MM, UNCLEAR_TIP_MM, HIDDEN_TIP_MM = 8.0, 1.0, 3.0, 12.0
"""Standard deviations of the tracker's tips (measured on virtual hands at 0.5 m: 4 mm off at the
median, 28 at worst), and of tips in the depth image: with and without two clear sides, and where
another finger hides them."""
LOWER_MM = 8.0
"""Of two possible places the fingertip is lower than a knuckle by this (chosen: half a finger's
thickness)."""
SHIFT_MM = 2.0
"""Standard deviation of a fingertip's way from frame to frame, by its hand's (measured on the
virtual camera: 0.6 mm at the median, 3 in one frame of a hundred)."""
CLAIM_US = 150_000
"""Greatest age of a detection that gives a finger's place (chosen: a slow tracker's delay)."""
BESIDE_MM = 12.0
"""The tracker's tips are rarely farther off; a neighbour's middle is 18 mm away (chosen)."""
STRAYED_MM = 30.0
"""A detection farther off than this is an error, or another finger is followed."""
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


class Phase(Enum):
    """What a track rests on."""

    TENTATIVE = auto()
    """A detection alone."""
    CONFIRMED = auto()
    """The last frame shows it."""
    COASTING = auto()
    """The last frames do not show it."""


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
    history: tuple[Kalman, ...]
    """The states after its measurements, oldest first, at most `REMEMBERED`: by the depth image,
    by detections while no frame shows it."""
    shown_us: int
    """When the depth image last showed it."""
    phase: Phase = Phase.TENTATIVE
    went_px: Pixel = (0.0, 0.0)
    """How far its hand went since its last detection."""
    sigma_mm: float = 0.0
    """Standard deviation of its last measured place."""
    off_mm: float = 0.0
    """How far the last detection is from where the finger was then."""
    off_place: int = 0
    """Detections in a row that are another finger's place."""
    pointer: Pointer | None = None
    """As last published; None for a new track."""
    moved: Kalman | None = None
    """Its state when it last moved."""
    detector: Detector | None = None
    debounce: Debounce = Debounce()  # noqa: RUF009 - frozen, so one default serves all
    motion: Motion = Motion()  # noqa: RUF009

    @property
    def side(self) -> Side:
        """Left or right, by majority."""
        return Side.UNKNOWN if self.votes == 0 else Side.RIGHT if self.votes > 0 else Side.LEFT

    @property
    def strayed(self) -> bool:
        """Whether the last detection contradicts its place."""
        return self.off_mm > STRAYED_MM

    def at(self, time_us: int) -> Kalman:
        """Return its state at a time: predicted, or the one of its history that is nearest."""
        last = self.history[-1]
        if time_us >= last.time_us:
            return predicted(last, time_us)
        return min(self.history, key=lambda past: abs(past.time_us - time_us))


def carry(finger: Track, maps: Sequence[HeightMap], px_per_mm: float) -> Track:
    """Return a track in the frame of the last map; `px_per_mm`: on the surface."""
    last, now_us = finger.history[-1], maps[-1].time_us
    if now_us - finger.shown_us > 1e6 * LONGEST_S:
        last = replace(last, velocity_mm_s=(0.0, 0.0))
    at_px = _pixel(last.place_mm, px_per_mm)
    x, y = _pixel(predicted(last, now_us).place_mm, px_per_mm)
    expected = x - at_px[0], y - at_px[1]
    shift = shift_px(maps[-2], maps[-1], at_px, expected) if len(maps) > 1 else None
    state = carried_on(last, shift, now_us, px_per_mm)
    (x, y), (dx, dy) = finger.went_px, shift or expected
    went_px = x + dx, y + dy
    return replace(finger, history=(*finger.history, state)[-REMEMBERED:], went_px=went_px)


def carried_on(state: Kalman, way_px: Pixel | None, time_us: int, px_per_mm: float) -> Kalman:
    """Return a state after the way that its hand went since; None: unknown."""
    if way_px is None:
        return predicted(state, time_us)
    return carried(state, time_us, (way_px[0] / px_per_mm, way_px[1] / px_per_mm), SHIFT_MM)


def predict(finger: Track, time_us: int, px_per_mm: float) -> Prediction:
    """Return a finger's predicted place; `px_per_mm`: on the surface."""
    tip = _pixel(finger.at(time_us).place_mm, px_per_mm)
    return Prediction(FingerFrame(tip, finger.direction, finger.px_per_mm), last_top_mm(finger))


def last_top_mm(finger: Track) -> float:
    """Return the height of a finger's upper side when it was last shown; nan where unknown."""
    return finger.pointer.diagnostics.top_mm if finger.pointer else math.nan


def claim(finger: Track, time_us: int) -> Prediction | None:
    """Return the detected place of a finger, moved on as its hand; None if it is too old."""
    seen = finger.detection
    if finger.phase is Phase.TENTATIVE or time_us - seen.time_us > CLAIM_US:
        return None
    (x, y), (dx, dy) = seen.tip_px, finger.went_px
    place = FingerFrame((x + dx, y + dy), unit(seen.distal_px, seen.tip_px), seen.px_per_mm)
    return Prediction(place, math.nan)


def is_there(claimed: Prediction, seen: Fingertip) -> bool:
    """Return whether a tip is at a detected place; one farther off is a knuckle or a neighbour."""
    place = claimed.place
    return math.dist(seen.tip_px, place.tip_px) < BESIDE_MM * place.px_per_mm


def is_better(finger: Track, claimed: Fingertip, followed: Fingertip | None) -> bool:
    """Return whether the detected place is right rather than the predicted one.

    A fingertip is below the knuckles of its hand: the lower of two places is accepted at once, one
    as low after several detections, a higher one never.
    """
    if followed is None:
        return True
    lower_mm = LOWER_MM if finger.off_place < INSISTS else -LOWER_MM
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


def detected(
    finger: Track, place_mm: Place, time_us: int, way_px: Pixel | None, px_per_mm: float
) -> tuple[Kalman, ...]:
    """Return the history of a track after a late detection, at the detection's own time.

    It corrects what no frame shows well; a measured tip is mostly ten times as exact. `way_px`: of
    its hand since then, which replaces worse measurements.
    """
    if finger.phase is not Phase.COASTING and finger.sigma_mm <= LANDMARK_MM:
        return finger.history
    before = tuple(past for past in finger.history if past.time_us <= time_us)
    if not before:
        return finger.history
    now_us = finger.history[-1].time_us
    state = corrected(predicted(before[-1], time_us), place_mm, LANDMARK_MM)
    return (*before, state, carried_on(state, way_px, now_us, px_per_mm))[-REMEMBERED:]


def measured(
    finger: Track,
    time_us: int,
    tip: Fingertip,
    followed: bool,
    scale: float,
    hidden: bool = False,
) -> Track:
    """Return a track corrected by its tip in the present frame.

    `followed`: found at its predicted place, so that its motion goes on; `scale`: px a mm on the
    surface; `hidden`: another finger is above it.
    """
    place_mm = tip.tip_px[0] / scale, tip.tip_px[1] / scale
    sigma_mm = TIP_MM if math.isfinite(tip.width_mm) else UNCLEAR_TIP_MM
    if hidden:
        sigma_mm = HIDDEN_TIP_MM
    if followed and finger.phase is not Phase.TENTATIVE:
        before = tuple(past for past in finger.history if past.time_us < time_us)
        state = corrected(finger.at(time_us), place_mm, sigma_mm)
    else:
        before, state = (), born(time_us, place_mm, sigma_mm)
    moved = finger.moved
    if moved is None or math.dist(moved.place_mm, state.place_mm) > MOVED_MM:
        moved = state
    return replace(
        finger,
        history=(*before, state)[-REMEMBERED:],
        shown_us=time_us,
        phase=Phase.CONFIRMED,
        sigma_mm=sigma_mm,
        moved=moved,
        px_per_mm=tip.px_per_mm,
    )


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
    return ELSEWHERE_CONFIDENCE if finger.strayed else 1.0


def coast(finger: Track, time_us: int, settings: SensingSettings) -> Track | None:
    """Return the track for a frame that does not show the finger, or None after a while."""
    pointer = finger.pointer
    if pointer is None or time_us - finger.shown_us > 1000.0 * settings.lost_after_ms:
        return None
    unsure = pointer.confidence * UNSHOWN_CONFIDENCE
    still = replace(pointer, vx_mm_s=0.0, vy_mm_s=0.0, confidence=unsure)
    return replace(finger, phase=Phase.COASTING, pointer=still)


def _pixel(place_mm: Place, px_per_mm: float) -> Pixel:
    return place_mm[0] * px_per_mm, place_mm[1] * px_per_mm


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
