"""The scenarios, one table: what one can write after `sim:`."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from halo_service.virtual.room import Room
from halo_service.virtual.scenarios import (
    awkward,
    calibration,
    chaos,
    demo,
    drumming,
    idle,
    labels,
    painting,
    projector,
    puppet,
    study,
    ten_fingers,
    threshold,
    typing,
)
from halo_service.virtual.stage import Play

Scenario = Callable[[Room, np.random.Generator], Play]

SCENARIOS: dict[str, Scenario] = {
    "demo": demo.demo,
    "idle": idle.idle,
    "calibration": calibration.calibration,
    "pointing": study.pointing,
    "hover": study.hover,
    "pressure": study.pressure,
    "threshold": threshold.threshold,
    "awkward": awkward.awkward,
    "typing": typing.typing,
    "typing-accurate": typing.accurate,
    "typing-fast": typing.fast,
    "drumming": drumming.drumming,
    "painting": painting.painting,
    "ten-fingers": ten_fingers.ten_fingers,
    "projector": projector.projector,
    "chaos": chaos.chaos,
    "labels": labels.labels,
    "hand": puppet.hand,
}
ENDING = frozenset({"calibration", "hover", "pressure", "threshold", "awkward", "labels"})
"""Scenarios that end by themselves; the others go on for ever."""
FURNISHED: dict[str, Callable[[Room], Room]] = {
    "projector": projector.lit,
    "chaos": chaos.dressed,
    "labels": labels.readable,
}
"""Scenarios that bring something along, or need something to be there."""


def play(scenario: str, room: Room) -> Play:
    """Begin a scenario, one of SCENARIOS, in a room that has been furnished for it."""
    return SCENARIOS[scenario](room, np.random.default_rng([room.seed, 2, *scenario.encode()]))
