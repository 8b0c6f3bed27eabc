"""The person at the virtual table, who follows the prompts of the calibration."""

from __future__ import annotations

import numpy as np
import pytest

from halo_calibration.guided.guide import PROMPTS
from halo_service.app.virtual_user.user import VirtualUser
from halo_service.virtual.sim_url import parse_sim_url


@pytest.mark.parametrize(("turned_deg", "from_far_edge"), [(0, False), (180, True)])
def test_the_user_of_an_installation_sits_where_the_canvas_has_them(
    turned_deg: int, from_far_edge: bool
) -> None:
    name = f"sim:crossing,cameras=2,camera=2,seed=3,angles_deg=0,{turned_deg}"
    user = VirtualUser(parse_sim_url(name).room, colour_times=0)
    empty = user.read(0.0).depth.astype(int)
    user.follow(PROMPTS["hover"])
    user.skip(1.5)
    depth = user.read(0.0).depth
    hand = (depth < empty - 25) & (depth > 0)
    at_edges = np.count_nonzero(hand[:40]), np.count_nonzero(hand[-40:])
    assert (at_edges[0] > 500, at_edges[1] > 500) == (from_far_edge, not from_far_edge)
