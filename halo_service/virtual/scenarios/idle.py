"""`idle`: the empty room."""

from __future__ import annotations

import numpy as np

from halo_service.virtual.room import Room
from halo_service.virtual.scenario import Scenario


def idle(room: Room, rng: np.random.Generator) -> Scenario:
    """No hands; never ends."""
    return Scenario(room, [])
