"""The held states: is the finger still, and are the signals separate and in order? Pure."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields, replace
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from halo_calibration.errors import NO_HALO, CalibrationError
from halo_calibration.observe import THICKNESS_MM, Observation
from halo_service.profile import Correction, TouchState, TouchStates
from halo_service.profile.model import Quality
from halo_service.sensing.correction import higher, leveled, strength
from halo_service.sensing.fingertips import TIP_RADIUS_MM

STATES = ("hover", "subtle", "touch", "pressure")
"""From the weakest halo to the strongest (paper 4.3.5)."""
HARD = "hard"
"""A press harder than the medium one: optional, and ours. It fixes the far end of the force."""
HELD_STATES = (*STATES, HARD)
HOLD_S = 2.0
"""How long each is held."""
LEAST_RECEIVED = 0.6
"""Share of a state's frames that must arrive at all."""
LEAST_SEEN = 0.5
"""Share of the frames that came in which the finger must be seen."""
STILL_MM = 5.0
"""90 % of a held finger's positions lie this near to their middle: an arm sways by half a mm, and
the fingertip is found to a mm or two."""
NO_HALO_MM_PX = 60.0
"""A press whose signal is less, and that stands apart from hover in no other reading, shows no
halo: six pixels of the patch's 600 at 10 mm."""
APART_SIGMAS = 1.5
"""Two neighbouring states must differ by so many standard deviations of one frame, in the reading
that separates them best (chosen: by three of their medians over two seconds of correlated noise).
Touches are then less sure, and say so, which serves a user better than none."""
CLEAR_SIGMAS = 3.0
"""A depth of the halo separates two states if they differ by so many."""
GOOD_SIGMAS = 6.0
"""From here on every single frame separates them."""
HALO_AHEAD_MM = 2.0
"""A finger hides the halo under it: at its sides the halo is deepest so far beyond the pad
(measured on the virtual camera, users with short nails)."""
LEAST_NAIL_MM, MOST_NAIL_MM = 1.5, 15.0
"""Less is an error of the measurement, more no nail (chosen)."""
MOST_STATED = 5000.0
"""No stated height in mm or force in grams is above, as on the control page."""
LEAST_HARDER = 1.3
"""A hard press is at least so many times the medium one, or it adds nothing (chosen)."""
NOISE_FLOOR_MM_PX = 10.0
"""No signal is steadier than a pixel that comes and goes at the patch's edge."""


@dataclass(frozen=True, slots=True)
class StateValues:
    """Heights and forces of the held states, and whether the user measured them.

    Assumed, the heights are the paper's (4.3.5) and a relaxed touch is taken as 25 g; the force
    of a medium press is then unknown.
    """

    hover_mm: float | None = None
    subtle_mm: float | None = None
    touch_g: float | None = None
    pressure_g: float | None = None
    hard_g: float | None = None
    """Of the hard press; None: it is not held."""

    def __post_init__(self) -> None:
        """Check each value, and the forces against each other. Raises `CalibrationError`."""
        for value in (getattr(self, each.name) for each in fields(self)):
            if value is not None and not 0.0 <= value <= MOST_STATED:
                raise CalibrationError(
                    f"a stated height or force of {value:g} is impossible; "
                    f"give mm or grams in range 0..{MOST_STATED:g}"
                )
        if self.hard_g is None:
            return
        if self.pressure_g is None:
            raise CalibrationError(
                "a hard press needs the grams of the medium one too: give both, as in "
                "--press-g 200 --hard-g 400"
            )
        if self.hard_g < LEAST_HARDER * self.pressure_g:
            raise CalibrationError(
                f"a hard press of {self.hard_g:g} g is too near to the medium one of "
                f"{self.pressure_g:g} g: press at least {LEAST_HARDER:g} times as hard"
            )

    @property
    def to_hold(self) -> tuple[str, ...]:
        """Return the states that are held, in order."""
        return STATES if self.hard_g is None else HELD_STATES

    def of(self, state: str) -> tuple[float, float, bool]:
        """Return a state's height in mm, its force in grams, and whether they were given."""
        given, height_mm, force_g = {
            "hover": (self.hover_mm, self.hover_mm or 10.0, 0.0),
            "subtle": (self.subtle_mm, self.subtle_mm or 1.0, 0.0),
            "touch": (self.touch_g, 0.0, self.touch_g or 25.0),
            "pressure": (self.pressure_g, 0.0, self.pressure_g or -1.0),
            HARD: (self.hard_g, 0.0, self.hard_g or -1.0),
        }[state]
        return height_mm, force_g, given is not None


@dataclass(frozen=True, slots=True)
class HoldObservations:
    """What was observed while one state was held."""

    state: str
    expected: int
    """Frames that the camera should have given in that time."""
    received: int
    """Frames that it gave."""
    observations: tuple[Observation, ...]
    """Frames in which the finger was found."""


@dataclass(frozen=True, slots=True)
class Middle:
    """One state, reduced."""

    signal: float
    """Median of the raw signal, mm px."""
    noise: float
    """Its standard deviation, robust, mm px."""
    spread_mm: float
    """90 % of the positions lie this near to their middle."""


def check_hold(held: HoldObservations) -> Middle:
    """Reduce one held state; raises `CalibrationError` where it was not held still or not seen."""
    require_frames(held.state, held.expected, held.received)
    require_seen(held.state, held.received, len(held.observations))
    where = np.array([(each.x_mm, each.y_mm) for each in held.observations])
    off = np.hypot(*(where - np.median(where, axis=0)).T)
    spread_mm = float(np.percentile(off, 90))
    if spread_mm > STILL_MM:
        raise CalibrationError(
            f"the finger moved by {spread_mm:.0f} mm during '{held.state}': rest the wrist, hold "
            f"still for {HOLD_S:.0f} seconds, and do this state again"
        )
    return Middle(*_reading([each.raw for each in held.observations], NOISE_FLOOR_MM_PX), spread_mm)


def require_frames(step: str, expected: int, received: int) -> None:
    """Raise `CalibrationError` where the camera dropped too many frames."""
    if received < LEAST_RECEIVED * expected:
        raise CalibrationError(
            f"only {received} of {expected} frames came during '{step}': the camera dropped the "
            f"others; plug it into a USB 3 port of its own, close other programs, and do it again"
        )


def require_seen(step: str, received: int, seen: int) -> None:
    """Raise `CalibrationError` where the hand tracker found the finger too rarely."""
    if seen < LEAST_SEEN * received:
        raise CalibrationError(
            f"the finger was found in only {seen} of {received} frames during '{step}': stretch "
            f"the index finger, curl the others, keep the whole hand in the camera's view, and do "
            f"it again"
        )


def solve_touch(
    holds: Mapping[str, HoldObservations], state_values: StateValues, correction: Correction | None
) -> tuple[TouchStates, float, Quality]:
    """Return the held states, how many standard deviations the nearest two are apart, quality.

    Raises `CalibrationError`: a state moved, two overlap or are swapped, or there is no halo.
    The reading of the halo that separates two states best decides. Where no depth of the halo does,
    the signal alone is used between them; the quality is then fair. A hard press that reads no
    stronger than the medium one is left out: there the halo no longer grows.
    """
    middles = {state: check_hold(holds[state]) for state in STATES}
    read = {state: _readings(holds[state]) for state in STATES}
    weak = max(middle.signal for middle in middles.values()) < NO_HALO_MM_PX
    if weak and _best(read["hover"], read["pressure"]).sigmas < CLEAR_SIGMAS:
        raise CalibrationError(NO_HALO)
    apart = min(_apart(low, high, read) for low, high in pairwise(STATES))
    hover_mm, subtle_mm = state_values.of("hover")[0], state_values.of("subtle")[0]
    if hover_mm <= subtle_mm:
        raise CalibrationError(
            f"a hover height of {hover_mm:g} mm is not above the subtle one of {subtle_mm:g} mm: "
            f"hold hover higher, as in --hover-mm 10 --subtle-mm 1"
        )
    # In the hover state, for nearer to the surface the halo lifts what the camera reads.
    seen = holds["hover"].observations
    states = TouchStates(
        **{state: _held_state(holds[state], middles[state], state_values) for state in STATES},
        line_px_at_hover=float(np.median([each.line_px for each in seen])),
        finger_thickness_mm=_finite([each.top_mm - hover_mm for each in seen], THICKNESS_MM),
        tip_radius_mm=_finite([each.width_mm / 2.0 for each in seen], TIP_RADIUS_MM),
        hard=_hard_state(holds, read["pressure"], state_values),
        nail_mm=nail_length_mm([*holds["touch"].observations, *holds["pressure"].observations]),
    )
    quality: Quality = "good" if apart >= GOOD_SIGMAS and dents_known(states) else "fair"
    return corrected(states, correction), apart, quality


def nail_length_mm(seen: Sequence[Observation]) -> float:
    """Return how far the outline of a touching finger reaches beyond its tip, along the finger."""
    behind_mm = _finite([each.halo_behind_mm for each in seen], -HALO_AHEAD_MM) + HALO_AHEAD_MM
    pitch_deg = _median([each.pitch_deg for each in seen])
    if behind_mm < LEAST_NAIL_MM:
        return 0.0
    return min(behind_mm / math.cos(math.radians(min(pitch_deg, 60.0))), MOST_NAIL_MM)


def _hard_state(
    holds: Mapping[str, HoldObservations], pressed: Readings, state_values: StateValues
) -> TouchState | None:
    if HARD not in holds:
        return None
    held = holds[HARD]
    middle = check_hold(held)
    if _best(pressed, _readings(held)).sigmas < APART_SIGMAS:
        return None
    return _held_state(held, middle, state_values)


def dents_known(states: TouchStates) -> bool:
    """Say whether a depth of the halo separates each two neighbouring states."""
    held = [_known_depths(getattr(states, state)) for state in STATES]
    return all(
        any(
            low and high and _sigmas(low, high) >= CLEAR_SIGMAS
            for low, high in zip(lower, upper, strict=True)
        )
        for lower, upper in pairwise(held)
    )


def _known_depths(state: TouchState) -> list[tuple[float, float] | None]:
    depths = zip(state.raw_readings[1:], state.noise[1:], strict=True)
    return [each if each[0] != 0.0 else None for each in depths]


def corrected(states: TouchStates, correction: Correction | None) -> TouchStates:
    """Apply a correction to the states, as every later signal will be."""
    return states.with_each(lambda held: _through(held, correction))


def _through(held: TouchState, correction: Correction | None) -> TouchState:
    raw_top_mm = held.top_mm if held.raw_top_mm is None else held.raw_top_mm
    if correction is None:
        return replace(
            held,
            signal=held.raw,
            readings=held.raw_readings,
            top_mm=raw_top_mm,
            raw_top_mm=raw_top_mm,
        )
    expected = strength(correction, held.x_mm, held.y_mm, held.pitch_deg, held.yaw_deg)
    readings, _ = leveled(held.raw_readings, correction, held.x_mm, held.y_mm)
    higher_mm, _ = higher(correction, held.x_mm, held.y_mm)
    return replace(
        held,
        signal=held.raw / expected,
        readings=readings,
        top_mm=None if raw_top_mm is None else raw_top_mm - higher_mm,
        raw_top_mm=raw_top_mm,
    )


def _held_state(held: HoldObservations, middle: Middle, state_values: StateValues) -> TouchState:
    height_mm, force_g, given = state_values.of(held.state)
    readings, noise = _readings(held)
    tops = [each.top_mm for each in held.observations if math.isfinite(each.top_mm)]
    top_mm, top_noise_mm = _reading(tops, 0.0) if tops else (None, 0.0)
    return TouchState(
        signal=middle.signal,
        height_mm=height_mm,
        force_g=force_g,
        stated=given,
        raw=middle.signal,
        x_mm=_median([each.x_mm for each in held.observations]),
        y_mm=_median([each.y_mm for each in held.observations]),
        pitch_deg=_median([each.pitch_deg for each in held.observations]),
        yaw_deg=_median([each.yaw_deg for each in held.observations]),
        readings=readings,
        raw_readings=readings,
        noise=noise,
        top_mm=top_mm,
        raw_top_mm=top_mm,
        seen_deg=_finite([each.seen_deg for each in held.observations], 45.0),
        top_noise_mm=top_noise_mm,
    )


Readings = tuple[tuple[float, ...], tuple[float, ...]]
"""Medians of all readings of one state, and their standard deviations from frame to frame."""


def _readings(held: HoldObservations) -> Readings:
    """Return the median and deviation of each reading; both 0 where it was often hidden."""
    medians, noises = [], []
    for each in zip(*(seen.readings for seen in held.observations), strict=True):
        shown = [value for value in each if math.isfinite(value)]
        known = len(shown) >= LEAST_SEEN * held.received
        median, noise = _reading(shown, 0.0) if known else (0.0, 0.0)
        medians.append(median)
        noises.append(noise)
    return tuple(medians), tuple(noises)


class _Separation(NamedTuple):
    """How far one state lies above another in one reading."""

    sigmas: float
    """In standard deviations of one frame."""
    low: float
    high: float
    """The medians, mm px or mm."""


def _best(low: Readings, high: Readings) -> _Separation:
    """Return the reading that separates two states best; the signal is always there."""
    floors = (NOISE_FLOOR_MM_PX, *(0.0 for _ in low[0][1:]))
    return max(
        _Separation(_sigmas((a, max(p, floor)), (b, max(q, floor))), a, b)
        for a, p, b, q, floor in zip(*low, *high, floors, strict=True)
        if floor or (a and b)  # 0: hidden
    )


def _apart(low: str, high: str, read: Mapping[str, Readings]) -> float:
    """Return the distance of two neighbouring states in standard deviations."""
    best = _best(read[low], read[high])
    values = f"('{low}' reads {best.low:.3g}, '{high}' {best.high:.3g})"
    if best.sigmas < -APART_SIGMAS:
        raise CalibrationError(
            f"'{low}' shows a stronger halo than '{high}' {values}: were the two swapped? The halo "
            f"grows from hover over subtle and touch to pressure; do these two again in that order"
        )
    if best.sigmas < APART_SIGMAS:
        raise CalibrationError(
            f"'{low}' and '{high}' overlap {values}: {_REMEDIES[high]}, and do both again"
        )
    return best.sigmas


_REMEDIES = {
    "subtle": "hover higher, where the halo just shows, then come as near as you can without "
    "touching",
    "touch": "keep clear of the surface in 'subtle', and lay the fingertip down in 'touch'",
    "pressure": "let the finger rest in 'touch', and press down firmly in 'pressure'",
}


def _reading(values: Sequence[float], floor: float) -> tuple[float, float]:
    """Return the median and the standard deviation, robust and no smaller than `floor`."""
    median = _median(values)
    return median, max(1.4826 * _median([abs(value - median) for value in values]), floor)


def _sigmas(low: tuple[float, float], high: tuple[float, float]) -> float:
    """Return how far one median lies above another, in standard deviations of one frame."""
    return (high[0] - low[0]) / max(math.hypot(low[1], high[1]) / math.sqrt(2.0), 1e-9)


def _finite(values: Sequence[float], otherwise: float) -> float:
    """Return the median of what was measured."""
    measured = [value for value in values if math.isfinite(value)]
    return _median(measured) if measured else otherwise


def _median(values: Sequence[float]) -> float:
    return float(np.median(values))
