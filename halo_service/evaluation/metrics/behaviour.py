"""How pointers behave: whether they stay one finger's, and are there only where a finger is."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from halo_service.evaluation.metrics.matching import NEAR_MM, match_pointers
from halo_service.evaluation.metrics.touches import Down, Touches, published
from halo_service.evaluation.metrics.truth import TrueFinger, TrueFrame, TrueTouch, Truth
from halo_service.geometry.surface import Surface
from halo_service.values import Finger, Side, Touch, TouchFrame

STUCK_US = 250_000
"""Chosen: a touch reported for this much longer than it lasted is stuck."""
LEFT_US = 300_000
"""Chosen: a hand that has just left may still have a pointer for that long."""
STRAY_MM = 60.0
"""Chosen: a pointer farther than this, in the plane, from any finger is stray."""
LOW_MM = 80.0
"""Chosen: below this, within the surface, a finger should have one pointer and keep it."""


@dataclass(frozen=True, slots=True)
class Behaviour:
    """Counts of what should not happen."""

    stuck: int = 0
    """Published touches, ghosts too, that lasted long after the finger had left, or for ever."""
    id_changes: int = 0
    """How often a finger that stayed got another id."""
    wrong_finger: int = 0
    """Touches reported as another finger or hand than the one that touched."""
    stray: int = 0
    """Pointers in frames where no pointing finger is, or just was, near them."""
    pointers: int = 0
    """Pointers in all frames: what `stray` is a share of."""
    without_pointer: int = 0
    """Active fingers low over the surface that had no pointer, counted once a frame."""
    fingers: int = 0
    """Active fingers low over the surface in all frames: what `without_pointer` is a share of."""
    hovering: int = 0
    """Pointers in the air in all frames: a method that reports touches alone has none."""


def score_behaviour(
    frames: Sequence[TouchFrame], truth: Truth, touches: Touches, surface: Surface
) -> Behaviour:
    """Count it."""
    without_pointer, fingers, id_changes = _followed(frames, truth, surface)
    return Behaviour(
        _stuck(frames, truth, touches),
        id_changes,
        sum(
            (hit.down.side, hit.down.finger) != (hit.touch.side, hit.touch.finger)
            for hit in touches.hits
        ),
        _stray(frames, truth),
        sum(len(frame.pointers) for frame in frames),
        without_pointer,
        fingers,
        sum(each.state is Touch.HOVER for frame in frames for each in frame.pointers),
    )


def _stuck(frames: Sequence[TouchFrame], truth: Truth, touches: Touches) -> int:
    """Count stuck touches: a hit should end with its own touch, others with any near."""
    ends = {hit.down: _end_us(hit.touch, touches.missed) for hit in touches.hits}
    return sum(
        _sticks(down.up_us, ends[down]) if down in ends else _lingers(down, frames, truth)
        for down in published(frames)
    )


def _end_us(touch: TrueTouch, missed: Sequence[TrueTouch]) -> int:
    """Return when a finger finally rose after a touch: a missed re-tap soon after it is no end.

    It counts as missed, so the touch that lasts over it does not count as stuck too.
    """
    end_us = touch.to_us
    for later in missed:  # in order of time
        soon = touch.to_us < later.from_us <= end_us + STUCK_US
        if soon and (later.side, later.finger) == (touch.side, touch.finger):
            end_us = later.to_us
    return end_us


def _sticks(up_us: int | None, to_us: int) -> bool:
    return up_us is None or up_us - to_us > STUCK_US


def _lingers(down: Down, frames: Sequence[TouchFrame], truth: Truth) -> bool:
    """Whether a touch lasts long while neither its finger nor one near it touches."""
    touched_us, x, y = down.time_us, down.x_mm, down.y_mm
    for frame in frames:
        true = truth.at(frame.time_us)
        if true is None or frame.time_us < down.time_us:
            continue
        if down.up_us is not None and frame.time_us > down.up_us:
            break
        pointer = next((each for each in frame.pointers if each.id == down.id), None)
        if pointer is not None:  # it may have been dragged along
            x, y = pointer.x_mm, pointer.y_mm
        if any(each.touching and _its_own(down, x, y, each) for each in true.fingers):
            touched_us = frame.time_us
        if frame.time_us - touched_us > STUCK_US:
            return True
    return False


def _its_own(down: Down, x_mm: float, y_mm: float, finger: TrueFinger) -> bool:
    """Whether a touch that is reported there can be this finger's."""
    near = np.hypot(finger.x_mm - x_mm, finger.y_mm - y_mm) <= NEAR_MM
    return bool(near) or (finger.side, finger.finger) == (down.side, down.finger)


def _stray(frames: Sequence[TouchFrame], truth: Truth) -> int:
    """Count pointers that belong to no finger."""
    recent: list[TrueFrame] = []
    count = 0
    for frame in frames:
        now = truth.at(frame.time_us)
        if now is None:
            continue
        recent = [r for r in (*recent, now) if r.time_us >= frame.time_us - LEFT_US]
        there = np.array([(f.x_mm, f.y_mm) for r in recent for f in r.fingers]).reshape(-1, 2)
        for pointer in frame.pointers:
            away = np.hypot(there[:, 0] - pointer.x_mm, there[:, 1] - pointer.y_mm)
            count += bool(away.min(initial=np.inf) > STRAY_MM)
    return count


def _followed(frames: Sequence[TouchFrame], truth: Truth, surface: Surface) -> tuple[int, int, int]:
    """Return how often a finger had no pointer, how many fingers there were, and new ids.

    Only active fingers need a pointer: the index fingers, and every finger that touches in this
    recording. The others need none, but one that has a pointer should keep it.
    """
    without = fingers = changes = 0
    active = {(touch.side, touch.finger) for touch in truth.touches}
    active |= {(side, Finger.INDEX) for side in Side}
    ids: dict[tuple[Side, Finger], int] = {}
    for frame in frames:
        true = truth.at(frame.time_us)
        present = {(f.side, f.finger) for f in (true.fingers if true else ()) if _low(f, surface)}
        ids = {who: id_ for who, id_ in ids.items() if who in present}
        fingers += len(present & active)
        without += len(present & active)
        for finger, pointer in match_pointers(frame, true):
            who = (finger.side, finger.finger)
            if who in present:
                without -= who in active
                changes += ids.get(who, pointer.id) != pointer.id
                ids[who] = pointer.id
    return without, fingers, changes


def _low(finger: TrueFinger, surface: Surface) -> bool:
    within = 0.0 <= finger.x_mm <= surface.width_mm and 0.0 <= finger.y_mm <= surface.height_mm
    return within and finger.height_mm < LOW_MM
