"""Takes of the virtual Kinect, drawn before anything is measured."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from halo_service.evaluation.latency.raw_frames import Handed, handed
from halo_service.geometry.camera import Camera
from halo_service.values import SourceKind
from halo_service.virtual.camera import FPS
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
class Take:
    """What both arrangements are given."""

    name: str
    kind: SourceKind
    camera: Camera
    captures: tuple[Handed, ...]
    contacts: tuple[TrueContact, ...] | None
    """None where nobody knows the truth."""


def draw(name: str, request: SimRequest, seconds: float, tick: Callable[[], object]) -> Take:
    """Draw a scenario at full quality, from where its hands are there; 33.3 ms a frame.

    `tick` is called after each frame. No frame is dropped: how often a device does is not at
    stake here.
    """
    acting, sensor = start_scenario(request.scenario, request.room), Sensor(request.room)
    first = round(OPENING_S * FPS)
    captures: list[Handed] = []
    contacts: list[TrueContact] = []
    for index in range(first + round(seconds * FPS)):
        t_s = index / FPS
        stage = acting.at(t_s)
        ended = acting.ended_contacts(t_s)
        if index < first:
            continue
        time_us = round(t_s * 1e6)
        captures.append(handed(sensor.frame(time_us, stage.hands, stage.things)))
        for each in ended:
            place = sensor.surface.to_camera(np.array([[each.x_mm, each.y_mm, 0.0]]))[0]
            x, y, z = place.tolist()
            contacts.append(
                TrueContact(round(each.from_s * 1e6), round(each.to_s * 1e6), (x, y, z))
            )
        tick()
    began_us = captures[0].time_us
    seen_whole = tuple(each for each in contacts if each.from_us > began_us)
    return Take(name, "virtual", sensor.camera, tuple(captures), seen_whole)
