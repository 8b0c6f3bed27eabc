"""`idle`: the empty room."""

from __future__ import annotations

import numpy as np

from halo_service.virtual.room import Room
from halo_service.virtual.stage import Play


def idle(room: Room, rng: np.random.Generator) -> Play:
    """Nobody, for ever."""
    return Play(room, [])
