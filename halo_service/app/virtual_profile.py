"""The virtual Kinect's own small profile, so that it runs before any calibration exists.

It is measured as a user would do it: the empty room, then a finger held in the four states, seen
by the same tracker and the same stages as later. The finger's true place is not looked at. Only
a live virtual source gets one; a recording never does.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from halo_service.app.config import Settings
from halo_service.app.eyes import Eyes
from halo_service.errors import UserError
from halo_service.profile import Profile
from halo_service.profile.fit import (
    FINGER_THICKNESS_MM,
    WANTED_FRAMES,
    fit_background,
    fit_states,
)
from halo_service.runtime.beside import Tracker
from halo_service.sensing.background import excess_depth
from halo_service.sensing.fingertips import locate, sightings
from halo_service.sensing.revealer import reveal
from halo_service.sensing.settings import SensingSettings
from halo_service.sensing.step import measure
from halo_service.values import Fingertip, Signal
from halo_service.virtual.hand import FingerPose, PosedHand, pointing, posed
from halo_service.virtual.room import Room
from halo_service.virtual.sensor import Sensor

FRAME_US = 33_333
HELD_FRAMES = 15
"""Frames a state is held: half a second."""
PITCH_DEG = 45.0
"""The paper's wedge (section 4.3.5)."""
HOVER_MM, SUBTLE_MM = 10.0, 1.0
TOUCH_G, PRESSURE_G = 25.0, 200.0
"""The held states as the paper describes them; here they are true, for the room is told so."""


def virtual_profile(room: Room, settings: Settings) -> Profile:
    """Calibrate on the virtual room. Raises `UserError` when its states cannot be told apart."""
    sensor = Sensor(room, colour_times=2)
    clock = iter(range(0, 10**9, FRAME_US))
    background = fit_background([sensor.frame(next(clock)).depth for _ in range(WANTED_FRAMES)])
    surface = sensor.surface
    empty = Profile("virtual", sensor.camera, surface, background, None, 1)
    eyes = Eyes(sensor.camera, empty, settings.tracking)
    centre = (surface.width_mm / 2, surface.height_mm / 2)
    held: dict[str, list[Signal]] = {}
    tops_mm: list[float] = []
    try:
        for state, height_mm, force_g in (
            ("hover", HOVER_MM, 0.0),
            ("subtle", SUBTLE_MM, 0.0),
            ("touch", 0.0, TOUCH_G),
            ("pressure", 0.0, PRESSURE_G),
        ):
            aim = FingerPose(*centre, height_mm, force_g, PITCH_DEG, 0.0)
            hand = posed(room.user, pointing(room.user, room.dominant, aim, curl=1.0))
            seen = list(_seen(sensor, hand, clock, eyes, empty, settings.sensing))
            held[state] = [signal for _, signal in seen]
            if state == "touch":
                tops_mm = [tip.top_mm for tip, _ in seen]
    finally:
        eyes.close()
    try:
        states = fit_states(
            held,
            tops_mm,
            hover_mm=HOVER_MM,
            subtle_mm=SUBTLE_MM,
            touch_g=TOUCH_G,
            pressure_g=PRESSURE_G,
        )
    except ValueError as error:
        raise UserError(
            f"the virtual room of seed {room.seed} on {room.material} cannot be calibrated: "
            f"{error}; choose another seed or material"
        ) from error
    return replace(empty, touch=states)


def _seen(
    sensor: Sensor,
    hand: PosedHand,
    clock: Iterator[int],
    tracker: Tracker,
    profile: Profile,
    settings: SensingSettings,
) -> Iterator[tuple[Fingertip, Signal]]:
    """Hold a hand still for a while and yield what the sensing's stages make of it."""
    for _ in range(HELD_FRAMES):
        frame = sensor.frame(next(clock), [hand])
        revealed = reveal(excess_depth(frame.depth, profile.background), settings)
        for sighting in sightings(tracker.look(frame)):
            still = (0.0, 0.0)
            tip = locate(sighting, still, revealed, frame.depth, profile, FINGER_THICKNESS_MM)
            yield tip, measure(revealed, tip)
