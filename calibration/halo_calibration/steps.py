"""The steps: what was seen becomes a change of the profile.

Rule: no prompts, no frames fetched, no files. Guided and scripted calibration share these.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from halo_calibration.background import halo_threshold, solve_background
from halo_calibration.change_surface import relaid
from halo_calibration.correction import Base, Reference, judge_correction, solve_correction
from halo_calibration.errors import Refused
from halo_calibration.observe import Look, Observation, Observer
from halo_calibration.plane import Plane, solve_plane, surface_from_view
from halo_calibration.surface_solver import check_size
from halo_calibration.sweep import (
    GOOD_COVERED,
    Samples,
    Swept,
    coverage,
    covered,
    judge_sweep,
)
from halo_calibration.touch import Held, Stated, corrected, dents_known, solve_touch
from halo_service.geometry.camera import Camera
from halo_service.profile import Profile, StepRecord, TouchStates
from halo_service.sensing.settings import SensingSettings
from halo_service.values import Frame, Side

Change = Callable[[Profile | None], Profile]
"""What a step makes of the profile as it is now; None: there is none yet."""
Watch = Callable[[Observation | None], None]
"""Is shown each frame's finger, for the live signal."""

STEPS = ("background", "surface", "touch", "sweep")
"""In the order in which they build on each other."""
SAME_MM, SAME_DEG = 3.0, 0.5
"""A new background whose plane agrees this well leaves the surface where it was."""
HANDS_LOOKED_FOR = 10
"""Every tenth frame of the background is searched for hands."""
FAIR_RESIDUAL_MM, FAIR_LEFT_OUT = 3.0, 0.25
"""Beyond these the plane is told as fair: the sensor's own unevenness is 1 to 2 mm."""
FAIR_CORRECTED = 0.15
"""A corrected touch that varies more over the sweep is told as fair."""
NO_DENTS = (
    "the dent under the fingertip was hidden or hardly deeper in one state than in the one before, "
    "so touch and force are read off the halo's strength and height off the finger's own depth"
)
"""Said of the four states."""


@dataclass(frozen=True, slots=True)
class Setup:
    """What stays the same over all steps of one calibration."""

    name: str
    """Of the profile."""
    camera: Camera
    date: str
    """When the frames were taken, ISO 8601 in UTC."""
    settings: SensingSettings = field(default_factory=SensingSettings)
    stated: Stated = field(default_factory=Stated)
    base: Base | None = None
    side: Side = Side.UNKNOWN
    """Unknown: one set of touch parameters for all fingers; else for that hand alone."""


def background_change(setup: Setup, frames: Sequence[Frame], look: Look) -> Change:
    """Take the empty surface, and the plane it lies in. Raises `Refused`."""
    background = solve_background([frame.depth for frame in frames])
    _refuse_hands(frames, look)
    plane = solve_plane(background, setup.camera)
    noise_mm = float(np.median(background.noise_mm[background.valid]))
    share = float(np.mean(background.valid))
    record = StepRecord(
        setup.date,
        "good",
        rounded(frames=len(frames), noise_mm=noise_mm, measured_share=share),
    )

    def change(before: Profile | None) -> Profile:
        surface = surface_from_view(plane)
        steps = {} if before is None else dict(before.steps)
        steps["background"] = record
        if before is None:
            fresh = Profile(setup.name, setup.camera, surface, background, None, 1)
        elif _agrees(before, plane):
            fresh = replace(before, background=background)
        else:
            # What was learnt over another plane holds no more.
            fresh = replace(
                before, surface=surface, background=background, touch=None, by_hand={},
                correction=None, projector=None, anchor=None,
            )  # fmt: skip
            steps = {"background": record}
        steps.setdefault("surface", _surface_record(setup, plane))
        return replace(fresh, halo_threshold_mm=halo_threshold(background), steps=steps)

    return change


def surface_change(setup: Setup, width_mm: float = 300.0, height_mm: float = 200.0) -> Change:
    """Lay the surface's frame anew, from the background that the profile has. Raises `Refused`
    for a size that no surface has."""
    check_size(width_mm, height_mm)

    def change(before: Profile | None) -> Profile:
        known = require(before, "surface")
        plane = solve_plane(known.background, setup.camera)
        return replace(
            relaid(known, surface_from_view(plane, width_mm, height_mm), setup.base),
            steps={**known.steps, "surface": _surface_record(setup, plane)},
        )

    return change


def hold(
    state: str, frames: Iterable[Frame], wanted: int, observer: Observer, watch: Watch
) -> Held:
    """Watch a finger that is held in one of the four states."""
    came, seen = _watched(frames, observer, watch)
    return Held(state, wanted, came, seen)


def touch_change(setup: Setup, helds: Mapping[str, Held]) -> Change:
    """Take the four states. Raises `Refused` at once where they are not good enough."""
    solve_touch(helds, setup.stated, None)

    def change(before: Profile | None) -> Profile:
        known = require(before, "touch")
        states, apart, quality = solve_touch(helds, setup.stated, known.correction)
        by_hand = dict(known.by_hand)
        everyone = states
        if setup.side is not Side.UNKNOWN:
            by_hand[setup.side] = states
            everyone = known.touch or states
        record = StepRecord(
            setup.date,
            quality,
            rounded(
                separation_sigmas=apart,
                **{f"{name}_mm_px": getattr(states, name).raw for name in helds},
            ),
            _touch_note(setup.stated, states),
        )
        return replace(
            known, touch=everyone, by_hand=by_hand, steps={**known.steps, "touch": record}
        )

    return change


def sweep(frames: Iterable[Frame], wanted: int, observer: Observer, watch: Watch) -> Swept:
    """Watch a finger that is drawn over the surface."""
    came, seen = _watched(frames, observer, watch)
    return Swept(wanted, came, seen)


def sweep_change(setup: Setup, swept: Swept, profile: Profile) -> Change:
    """Take the sweep over a profile's surface. Raises `Refused` where it is not good enough."""
    surface = profile.surface
    samples = judge_sweep(swept, surface)
    fit = judge_correction(surface, setup.base, samples)
    if fit.corrected > fit.raw and fit.corrected > FAIR_CORRECTED:
        raise Refused(
            f"the halo of the sweep cannot be predicted ({100 * fit.corrected:.0f} % is left of "
            f"{100 * fit.raw:.0f} %): rest the finger on the wedge all the time, draw it slowly "
            f"and evenly, and sweep again"
        )
    share = coverage(covered(samples, surface))
    good = share >= GOOD_COVERED and fit.corrected < FAIR_CORRECTED
    record = StepRecord(
        setup.date,
        "good" if good else "fair",
        rounded(
            samples=len(samples),
            covered_share=share,
            variation_raw=fit.raw,
            variation_corrected=fit.corrected,
        ),
        "" if setup.base else "no base model: pitches other than the wedge's are not corrected",
    )

    def change(before: Profile | None) -> Profile:
        known = require(before, "sweep")
        return _with_correction(known, setup.base, samples, record)

    return change


def require(profile: Profile | None, step: str) -> Profile:
    """Return the profile that a step builds on; raises `Refused` where the step before lacks."""
    if profile is None:
        raise Refused(f"'{step}' needs the background first: run 'halo calibrate background'")
    if step == "sweep" and profile.touch is None:
        raise Refused("'sweep' needs the four states first: run 'halo calibrate touch'")
    return profile


def _with_correction(
    known: Profile, base: Base | None, samples: Samples | None, record: StepRecord
) -> Profile:
    assert known.touch is not None  # `require` saw to it
    held = known.touch.touch
    at = Reference(held.x_mm, held.y_mm, held.pitch_deg, held.yaw_deg)
    correction = solve_correction(known.surface, base, samples, at)
    return replace(
        known,
        correction=correction,
        touch=corrected(known.touch, correction),
        by_hand={side: corrected(each, correction) for side, each in known.by_hand.items()},
        steps={**known.steps, "sweep": record},
    )


def _watched(
    frames: Iterable[Frame], observer: Observer, watch: Watch
) -> tuple[int, tuple[Observation, ...]]:
    came, seen = 0, []
    for frame in frames:
        came += 1
        observation = observer.see(frame)
        watch(observation)
        if observation is not None:
            seen.append(observation)
    return came, tuple(seen)


def _refuse_hands(frames: Sequence[Frame], look: Look) -> None:
    looked = frames[::HANDS_LOOKED_FOR]
    found = sum(bool(look(frame).hands) for frame in looked)
    if found >= max(2, len(looked) // 3):
        raise Refused(
            "a hand was in the camera's view while the background was taken: take it away, and "
            "take the background again"
        )


def _agrees(before: Profile, plane: Plane) -> bool:
    normal = before.surface.camera_from_surface[:3, 2]
    origin = before.surface.camera_from_surface[:3, 3]
    distance_mm = float(normal @ origin / normal[2])
    turned = float(np.degrees(np.arccos(np.clip(normal @ np.array(plane.normal), -1.0, 1.0))))
    return abs(distance_mm - plane.distance_mm) < SAME_MM and turned < SAME_DEG


def _surface_record(setup: Setup, plane: Plane) -> StepRecord:
    good = plane.residual_mm < FAIR_RESIDUAL_MM and plane.left_out < FAIR_LEFT_OUT
    return StepRecord(
        setup.date,
        "good" if good else "fair",
        rounded(
            residual_mm=plane.residual_mm,
            left_out_share=plane.left_out,
            distance_mm=plane.distance_mm,
            tilt_deg=plane.tilt_deg,
        ),
        plane.note,
    )


def _touch_note(stated: Stated, states: TouchStates) -> str:
    heights = stated.of("hover")[2] and stated.of("subtle")[2]
    force = stated.of("pressure")[2]
    parts = [
        "" if heights else "heights are assumed (10 and 1 mm)",
        "" if force else "the press's force is unknown, so no grams are told",
        "" if dents_known(states) else NO_DENTS,
    ]
    return "; ".join(part for part in parts if part)


def rounded(**figures: float) -> dict[str, float]:
    """Return a step's figures as they are kept."""
    return {name: round(float(value), 4) for name, value in figures.items()}
