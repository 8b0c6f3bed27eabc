"""From frames to samples.

Rule: pure. Times are those of LSL's clock, s; the caller passes a function that maps the frames'
time.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

from halo_client import Began, Ended, touches
from halo_lsl.streams import FINGER, SLOTS
from halo_protocol import Down, Finger, Hand, Pointer, TouchFrame, Up

NAN = math.nan
LONGEST_GAP_S = 3.0
"""A longer gap is not filled: the service was lost."""
UNKNOWN = "unknown"

ToLsl = Callable[[float], float]
"""Frame time to LSL time, both s."""


@dataclass(frozen=True, slots=True)
class Sample:
    """Values of one time."""

    time_s: float
    values: tuple[float, ...]


@dataclass(frozen=True, slots=True)
class Marker:
    """A word of one time."""

    time_s: float
    text: str


class Regular:
    """A sample each period: gaps of the frames are filled with NaN."""

    def __init__(self, rate_hz: float) -> None:
        self._period_s = 1.0 / rate_hz
        self._last_s: float | None = None

    def samples(self, frame: TouchFrame, time_s: float) -> list[Sample]:
        """Return the samples since the last frame; none for a frame that is not later."""
        last_s, values = self._last_s, pointer_values(frame)
        if last_s is not None and time_s - last_s < self._period_s / 2:
            return []
        self._last_s = time_s
        filled: list[Sample] = []
        if last_s is not None and time_s - last_s <= LONGEST_GAP_S:
            steps = round((time_s - last_s) / self._period_s)
            step_s = (time_s - last_s) / max(steps, 1)
            empty = (NAN,) * len(values)
            filled = [Sample(last_s + n * step_s, empty) for n in range(1, steps)]
        return [*filled, Sample(time_s, values)]


def pointer_values(frame: TouchFrame) -> tuple[float, ...]:
    """Return the number of fingers and the values of each slot; NaN for an empty one."""
    slots = {pointer.slot: pointer for pointer in frame.pointers}
    values = [float(len(frame.pointers))]
    for slot in range(SLOTS):
        pointer = slots.get(slot)
        values += (NAN,) * len(FINGER) if pointer is None else _finger_values(pointer)
    return tuple(values)


def contact_samples(
    frame: TouchFrame, size_mm: tuple[float, float], to_lsl: ToLsl
) -> list[tuple[Sample, Marker]]:
    """Return the touches that begin or end, in order of time, each also as a marker."""
    living = {pointer.id: pointer for pointer in frame.pointers}
    found = [
        _contact(each, living, size_mm, to_lsl)
        for each in touches(frame)
        if isinstance(each, Began | Ended)
    ]
    return sorted(found, key=lambda pair: pair[0].time_s)


def _finger_values(pointer: Pointer) -> tuple[float, ...]:
    force_g = NAN if pointer.force_g < 0 else pointer.force_g
    return (
        pointer.id,
        pointer.hand,
        pointer.finger,
        float(pointer.touching),
        pointer.x_mm,
        pointer.y_mm,
        pointer.hover_mm,
        pointer.pressure,
        force_g,
        pointer.vx_mm_s,
        pointer.vy_mm_s,
        pointer.confidence,
    )


def _contact(
    touch: Began | Ended,
    living: dict[int, Pointer],
    size_mm: tuple[float, float],
    to_lsl: ToLsl,
) -> tuple[Sample, Marker]:
    event: Down | Up = touch.down if isinstance(touch, Began) else touch.up
    pointer = living.get(event.id)
    hand, finger = (NAN, NAN) if pointer is None else (pointer.hand, pointer.finger)
    strike = touch.down.strike_mm_s if isinstance(touch, Began) else NAN
    values = (
        float(isinstance(touch, Began)),
        event.id,
        event.contacts,
        hand,
        finger,
        event.u * size_mm[0],
        event.v * size_mm[1],
        NAN if strike < 0 else strike,
    )
    verb = "down" if isinstance(touch, Began) else "up"
    time_s = to_lsl(touch.time_us / 1e6)
    return Sample(time_s, values), Marker(time_s, f"{verb}/{_who(pointer)}")


def _who(pointer: Pointer | None) -> str:
    """Hand and finger, such as `right/index`."""
    if pointer is None:
        return f"{UNKNOWN}/{UNKNOWN}"
    hand = Hand(pointer.hand).name.lower() if pointer.hand in set(Hand) else UNKNOWN
    finger = Finger(pointer.finger).name.lower() if pointer.finger in set(Finger) else UNKNOWN
    return f"{hand}/{finger}"
