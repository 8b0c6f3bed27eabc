"""A scenario as recordings want it: every frame at full quality, as fast as it can be drawn."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from halo_service.values import Frame
from halo_service.virtual import truth
from halo_service.virtual.camera import FPS
from halo_service.virtual.naming import Wish
from halo_service.virtual.plays import play
from halo_service.virtual.sensor import Sensor

START_US = 500_000
"""Timestamp of the first frame: a device's clock does not start at 0."""
JITTER_US = 700.0
"""Of the timestamps, one sigma; chosen."""


def frames(
    wish: Wish, seconds: float, *, colour: bool = True
) -> Iterator[tuple[Frame | None, list[truth.Line]]]:
    """Yield each frame with the lines of truth that belong beside it.

    The frame is None where the device dropped it: no frame, no line of its own, but touches that
    ended meanwhile are still told. Timestamps are whole milliseconds, as Matroska keeps them, so
    that frame and truth agree after reading back.
    """
    room = wish.room
    scenario = play(wish.scenario, room)
    sensor = Sensor(room, colour_times=1 if colour else 0, started_us=START_US)
    rng = np.random.default_rng([room.seed, 3])
    for index in range(round(seconds * FPS)):
        late = abs(rng.normal(0.0, JITTER_US)) if index else 0.0
        dropped = index > 0 and rng.random() < room.drop
        time_us = START_US + round((index * 1e6 / FPS + late) / 1000.0) * 1000
        t_s = (time_us - START_US) / 1e6
        stage = scenario.at(t_s)
        lines = [
            truth.contact_line(c, sensor.surface, START_US) for c in scenario.ended_contacts(t_s)
        ]
        if dropped:
            yield None, lines
            continue
        lines.append(truth.frame_line(time_us, sensor.camera, sensor.surface, stage.hands))
        yield sensor.frame(time_us, stage.hands, stage.things), lines
