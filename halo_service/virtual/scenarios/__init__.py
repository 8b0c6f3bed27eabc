"""The scenarios, one table: what one can write after `sim:`."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from halo_service.virtual.room import Room
from halo_service.virtual.scenario import Scenario
from halo_service.virtual.scenarios import (
    awkward,
    calibration,
    chaos,
    controlled,
    crossing,
    demo,
    drumming,
    idle,
    labels,
    painting,
    projector,
    study,
    ten_fingers,
    threshold,
    typing,
)
from halo_service.virtual.scenarios.common import at_near_edge

SCENARIOS: dict[str, Callable[[Room, np.random.Generator], Scenario]] = {
    "demo": demo.demo,
    "idle": idle.idle,
    "calibration": calibration.calibration,
    "calibration-hard": calibration.with_hard_press,
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
    "hand": controlled.hand,
    "crossing": crossing.crossing,
}
ENDING = frozenset(
    {"calibration", "calibration-hard", "hover", "pressure", "threshold", "awkward", "labels"}
)
"""Scenarios that end by themselves; the others never end."""
ROOM_CHANGES: dict[str, Callable[[Room], Room]] = {
    "projector": projector.lit,
    "chaos": chaos.dressed,
    "labels": labels.readable,
    "crossing": at_near_edge,
}
"""Scenarios that add something to the room, or check that it is there."""
CAMERAS = {"crossing": {"cameras": "2"}}
"""Options that a scenario has unless they are given."""
FOR_INSTALLATIONS = ("crossing", "idle")
"""Scenarios that several cameras can show; the others are for one."""


def start_scenario(scenario: str, room: Room) -> Scenario:
    """Start a scenario, one of SCENARIOS, in a room already changed by ROOM_CHANGES."""
    return SCENARIOS[scenario](room, np.random.default_rng([room.seed, 2, *scenario.encode()]))
