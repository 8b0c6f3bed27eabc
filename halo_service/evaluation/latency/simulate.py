"""Recordings of the virtual camera, simulated before anything is measured."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from halo_service.evaluation.latency.raw_frames import RawFrame, to_raw
from halo_service.geometry.camera import Camera
from halo_service.values import SourceKind
from halo_service.virtual.scenarios import start_scenario
from halo_service.virtual.sensor import Sensor
from halo_service.virtual.sim_url import SimRequest

OPENING_S = 3.5
"""Scenarios begin with an empty table; hands are there by then."""


@dataclass(frozen=True, slots=True)
class TrueContact:
    """A touch as it really was."""

    from_us: int
    to_us: int
    camera_mm: tuple[float, float, float]
    """The pad's place, depth camera's frame."""


@dataclass(frozen=True, slots=True, eq=False)
class LatencyRecording:
    """The frames for both arrangements."""

    name: str
    kind: SourceKind
    camera: Camera
    frames: tuple[RawFrame, ...]
    contacts: tuple[TrueContact, ...] | None
    """None where the truth is unknown."""


def simulate(
    name: str, request: SimRequest, seconds: float, tick: Callable[[], object]
) -> LatencyRecording:
    """Simulate a scenario at full quality from OPENING_S on; no frame is dropped.

    `tick` is called after each frame.
    """
    scenario, sensor = start_scenario(request.scenario, request.room), Sensor(request.room)
    fps = sensor.camera.fps
    first = round(OPENING_S * fps)
    frames: list[RawFrame] = []
    contacts: list[TrueContact] = []
    for index in range(first + round(seconds * fps)):
        t_s = index / fps
        moment = scenario.at(t_s)
        ended = scenario.ended_contacts(t_s)
        if index < first:
            continue
        time_us = round(t_s * 1e6)
        frames.append(to_raw(sensor.frame(time_us, moment.hands, moment.things)))
        for each in ended:
            place = sensor.surface.to_camera(np.array([[each.x_mm, each.y_mm, 0.0]]))[0]
            x, y, z = place.tolist()
            contacts.append(
                TrueContact(round(each.from_s * 1e6), round(each.to_s * 1e6), (x, y, z))
            )
        tick()
    began_us = frames[0].time_us
    whole = tuple(each for each in contacts if each.from_us > began_us)
    return LatencyRecording(name, "virtual", sensor.camera, tuple(frames), whole)
