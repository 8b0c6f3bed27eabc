"""`projector`: an index finger at work in projected light; the picture changes by itself."""

from __future__ import annotations

import dataclasses

import numpy as np

from halo_service.virtual.room import Room
from halo_service.virtual.scenario import Scenario
from halo_service.virtual.scenarios.demo import demo

PICTURE = "colours"
"""The picture if the URL names none."""


def lit(room: Room) -> Room:
    """The room with its projector on."""
    return room if room.projected else dataclasses.replace(room, projected=PICTURE)


def projector(room: Room, rng: np.random.Generator) -> Scenario:
    """As `demo`."""
    return demo(room, rng)
