"""What the node of one virtual camera publishes, from frames to lines."""

from __future__ import annotations

import pytest

from halo_service.app.recordings.node_streams import DELAY_MS, node_stream
from halo_service.app.virtual_user.profile import virtual_profile
from halo_service.settings import Settings
from halo_service.virtual.clock import clock_of
from halo_service.virtual.sim_url import parse_sim_url


@pytest.mark.long
def test_a_node_publishes_the_same_lines_on_every_run() -> None:
    request, settings = parse_sim_url("sim:crossing,cameras=2,camera=2,seed=11"), Settings()
    profile = virtual_profile(request.room, settings)
    first, second = (list(node_stream(request, profile, settings, "b", 2.5)) for _ in range(2))
    assert first == second
    clock = clock_of(request.room, request.scenario)
    for line in first:
        late_ms = (line["arrived_us"] - 1e6 * clock.host_s(line["time_us"])) / 1e3
        assert DELAY_MS <= late_ms < DELAY_MS + 60.0
    assert any(line["pointers"] for line in first)
