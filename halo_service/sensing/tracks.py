"""What is remembered of a finger from frame to frame, and where it should therefore be.

The tracker says that there is a finger, which one, and about where. From then on the depth says
where it is: the tracker loses a hand in every tenth frame, sees one twice, or mistakes a left one
for a right one, and none of that may cost a finger its place, its id or its touch.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from halo_service.sensing.debounce import Debounce
from halo_service.sensing.detections import Detection, Pixel
from halo_service.sensing.detector import Detector
from halo_service.sensing.finger_frame import unit
from halo_service.sensing.label_pixels import Prediction
from halo_service.sensing.pointers import Motion
from halo_service.sensing.settings import SensingSettings
from halo_service.values import Fingertip, Pointer, Side, TouchEvent

LOWER_MM = 8.0
"""Of two places that a finger may be at, the fingertip hangs lower than a knuckle (chosen: half a
finger's thickness)."""
REMEMBERED = 8
"""Tips kept a finger: the slowest tracker's lag at 30 frames a second."""
CLAIM_US = 150_000
"""So old may a sighting be that says where a finger is (chosen: a slow tracker's lag)."""
BESIDE_PX = 12.0
"""Farther off the tracker's tips are seldom, and a neighbour's middle is 18 px away (chosen)."""
INSISTS = 4
"""Sightings in a row: the tracker errs singly and, on hands that overlap, in runs (chosen)."""
MOVED_PX = 5.0
"""A tip that went so far has moved (chosen: more than its noise, less than a hand at rest drifts
in a second or two)."""
LEFT_BEHIND_US, HELD_US = 2_000_000, 10_000_000
"""What the tracker calls no finger for so long, and what does not move either, is a thing: a pen,
a mug. A touch is believed longer, for a finger that presses is still (chosen)."""
SILENT_CONFIDENCE, ASTRAY_CONFIDENCE = 0.6, 0.6
"""Factors where the tracker has not seen a finger lately, and where it sees it elsewhere."""
UNSHOWN_CONFIDENCE = 0.4
"""Factor for each frame that does not show a finger."""
GAP_FRAMES = 2.0
"""Over a gap in time a finger is carried on for at most this many of its last steps."""


@dataclass(frozen=True, slots=True)
class Past:
    """Where a tip was."""

    time_us: int
    tip_px: Pixel


@dataclass(frozen=True, slots=True)
class Track:
    """One finger, from when it is first seen until it is gone."""

    id: int
    slot: int
    detection: Detection
    """The tracker's last word on it."""
    direction: Pixel
    """Unit vector from joint to tip in the image, smoothed over the sightings."""
    votes: int
    """For a right hand less those for a left one, over the last sightings."""
    shown_us: int
    """When the depth last showed it."""
    off_path: int = 0
    """Sightings in a row that lie beside its path."""
    contradicted: int = 0
    """Sightings in a row that contradicted its path."""
    pointer: Pointer | None = None
    """As last published; None for a newcomer."""
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
    """Return where a finger should be: by its own path, for a newcomer by the tracker."""
    if not finger.path:
        return Prediction(finger.detection.tip_px, finger.direction, math.nan)
    tip = _moved(finger.path[-1].tip_px, _ahead(finger.path, time_us))
    top_mm = finger.pointer.diagnostics.top_mm if finger.pointer else math.nan
    return Prediction(tip, finger.direction, top_mm)


def claim(finger: Track, time_us: int) -> Prediction | None:
    """Return where the tracker sees a finger, None where it has not seen it for a while."""
    if not finger.path or time_us - finger.detection.time_us > CLAIM_US:
        return None
    tip, joint = finger.detection.tip_px, finger.detection.distal_px
    return Prediction(tip, unit(joint, tip), math.nan)


def is_there(finger: Track, claimed: Prediction, expected: Prediction, seen: Fingertip) -> bool:
    """Say whether a tip lies where the tracker saw it, or as far off as the finger went since.

    What is found farther off, about that place, is a knuckle or another finger.
    """
    then = was_at(finger.path, finger.detection.time_us) if finger.path else expected
    went_px = math.dist(expected.tip_px, then.tip_px)
    return math.dist(seen.tip_px, claimed.tip_px) < BESIDE_PX + went_px


def was_at(path: tuple[Past, ...], time_us: int) -> Past:
    """Return where a finger was at a time, or next to it."""
    return min(path, key=lambda past: abs(past.time_us - time_us))


def is_better(finger: Track, claimed: Fingertip, followed: Fingertip | None) -> bool:
    """Say whether a finger is where the tracker claims rather than where its path went.

    A fingertip hangs below the knuckles of its hand: the lower of two places is believed at once,
    one as low when the tracker insists, one higher up never.
    """
    if followed is None:
        return True
    lower_mm = LOWER_MM if finger.off_path < INSISTS else -LOWER_MM
    return claimed.top_mm < followed.top_mm - lower_mm


def detection_at(finger: Track, expected: Prediction) -> Detection:
    """Return the tracker's last word on a finger, moved to where it is expected now."""
    tip, joint = finger.detection.tip_px, finger.detection.distal_px
    back, (dx, dy) = math.dist(tip, joint), expected.direction
    place = expected.tip_px
    return replace(
        finger.detection,
        side=finger.side,
        tip_px=place,
        distal_px=(place[0] - back * dx, place[1] - back * dy),
    )


def along(finger: Track, now: Past, followed: bool) -> Track:
    """Return a finger with its tip in the present frame; `followed` along its path, or anew."""
    moved = finger.moved
    if moved is None or math.dist(moved.tip_px, now.tip_px) > MOVED_PX:
        moved = now
    path = (*(finger.path if followed else ()), now)[-REMEMBERED:]
    return replace(finger, path=path, moved=moved, shown_us=now.time_us)


def is_abandoned(finger: Track, time_us: int) -> bool:
    """Say whether what was followed is no finger: it lies still, and the tracker sees none."""
    if finger.moved is None:
        return False
    believed_us = HELD_US if finger.debounce.contact.touching else LEFT_BEHIND_US
    return time_us - max(finger.detection.time_us, finger.moved.time_us) > believed_us


def doubt(finger: Track, time_us: int) -> float:
    """Return the factor for a finger that the tracker does not confirm where it is."""
    if time_us - finger.detection.time_us > CLAIM_US:
        return SILENT_CONFIDENCE
    return ASTRAY_CONFIDENCE if finger.contradicted else 1.0


def coast(finger: Track, time_us: int, settings: SensingSettings) -> Track | None:
    """Return a finger that the present frame does not show as it was, or None after a while."""
    pointer = finger.pointer
    if pointer is None or time_us - finger.shown_us > 1000.0 * settings.lost_after_ms:
        return None
    unsure = pointer.confidence * UNSHOWN_CONFIDENCE
    return replace(finger, pointer=replace(pointer, vx_mm_s=0.0, vy_mm_s=0.0, confidence=unsure))


def _ahead(path: tuple[Past, ...], time_us: int) -> Pixel:
    """Return how far a tip goes on from its last place at its last speed, px."""
    last, before = path[-1], path[max(len(path) - 2, 0)]
    steps = (time_us - last.time_us) / max(last.time_us - before.time_us, 1)
    steps = min(steps, GAP_FRAMES) if len(path) > 1 else 0.0
    return steps * (last.tip_px[0] - before.tip_px[0]), steps * (last.tip_px[1] - before.tip_px[1])


def _moved(place: Pixel, by: Pixel) -> Pixel:
    return place[0] + by[0], place[1] + by[1]


def changes(before: Track, now: Track | None) -> tuple[TouchEvent, ...]:
    """Return the event between two frames of one finger: at most one.

    A finger that goes (`now` is None) while it touches owes an up: no touch sticks.
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
