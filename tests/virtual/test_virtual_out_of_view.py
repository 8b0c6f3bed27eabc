"""What is out of the camera's view is not in its images."""

from __future__ import annotations

import numpy as np
import pytest

from halo_service.virtual.hand import pointing
from halo_service.virtual.scenarios.common import away
from halo_service.virtual.sensor import Sensor
from halo_service.virtual.sim_url import parse_sim_url
from halo_service.virtual.skeleton import posed


@pytest.mark.parametrize("seed", [1, 2, 5])
def test_a_hand_next_to_the_body_leaves_no_trace(seed: int) -> None:
    room = parse_sim_url(f"sim?seed={seed}").room
    sensor = Sensor(room, colour_times=2)
    gone = posed(room.user, pointing(room.user, room.dominant, away(room, room.dominant)))
    empty, without = sensor.frame(0), sensor.frame(0, [gone])
    np.testing.assert_array_equal(empty.depth, without.depth)
    assert isinstance(empty.colour, np.ndarray)
    assert isinstance(without.colour, np.ndarray)
    np.testing.assert_array_equal(empty.colour, without.colour)
