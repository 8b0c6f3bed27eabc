"""The scenarios, one table: what one can write after `sim:`."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from halo_service.virtual.plays.calibration import calibration
from halo_service.virtual.plays.chaos import chaos, dressed
from halo_service.virtual.plays.demo import demo
from halo_service.virtual.plays.drumming import drumming
from halo_service.virtual.plays.idle import idle
from halo_service.virtual.plays.labels import labels
from halo_service.virtual.plays.painting import painting
from halo_service.virtual.plays.projector import lit, projector
from halo_service.virtual.plays.puppet import hand
from halo_service.virtual.plays.study import hover, pointing, pressure
from halo_service.virtual.plays.ten_fingers import ten_fingers
from halo_service.virtual.room import Room
from halo_service.virtual.stage import Play

Scenario = Callable[[Room, np.random.Generator], Play]

SCENARIOS: dict[str, Scenario] = {
    "demo": demo,
    "idle": idle,
    "calibration": calibration,
    "pointing": pointing,
    "hover": hover,
    "pressure": pressure,
    "drumming": drumming,
    "painting": painting,
    "ten-fingers": ten_fingers,
    "projector": projector,
    "chaos": chaos,
    "labels": labels,
    "hand": hand,
}
ENDING = frozenset({"calibration", "hover", "pressure", "labels"})
"""Scenarios that end by themselves; the others go on for ever."""
FURNISHED: dict[str, Callable[[Room], Room]] = {"projector": lit, "chaos": dressed}
"""Scenarios that bring things into the room which are not there otherwise."""


def play(scenario: str, room: Room) -> Play:
    """Begin a scenario, one of SCENARIOS, in a room that has been furnished for it."""
    return SCENARIOS[scenario](room, np.random.default_rng([room.seed, 2, *scenario.encode()]))
