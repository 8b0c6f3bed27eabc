"""`halo doctor --network` in networks with faults, several doctors at once."""

from __future__ import annotations

import re

import pytest

from tests.networks.lab import Air, Lab, Program
from tests.networks.page import recipe

pytestmark = pytest.mark.long

ROUTER = "tcp/192.168.20.1:7447"


def doctor(lab: Lab, machine: str, *endpoints: str) -> Program:
    """Start the doctor."""
    words = [word for each in endpoints for word in ("--connect", each)]
    return lab.machines[machine].start("halo", "doctor", "--network", *words)


def test_it_explains_what_cannot_be_reached_and_what_a_router_passes_on(lab: Lab) -> None:
    tables = {each: f"192.168.10.{10 + n}/24" for n, each in enumerate(("table", "wall", "clone"))}
    lab.network("eth0", router="192.168.10.1/24", **tables)
    lab.network("eth1", router="192.168.20.1/24", laptop="192.168.20.20/24")
    page = recipe("A router between two networks")
    for each in ("wall", "clone"):  # two machines with one name
        text = page.files["table", "halo.toml"].replace("desk", "wall")
        page.files[each, "halo.toml"] = text
    page.write(lab)
    page.start(lab, "router").wait_for("ready")
    for each in tables:
        lab.machines[each].start("halo", "test-pattern")
    reached = doctor(lab, "laptop", ROUTER)
    away = doctor(
        lab, "laptop", "tcp/192.168.10.10:7447", "tcp/192.168.20.1:80", "tcp/192.168.20.99:7447"
    )
    text = reached.ended(60.0)
    assert "eth1 192.168.20.20/24" in text
    assert f"ok      {ROUTER}: a router with Zenoh 1." in text
    assert re.search("ok      node desk/table: [23][0-9] frames/s, 0.0 % lost", text), text
    assert "fail    node wall: several services have this name" in text
    assert reached.code == 1
    text = away.ended(60.0)
    assert "fail    tcp/192.168.10.10:7447: there is no way to it (Network is unreachable)" in text
    assert "fail    tcp/192.168.20.1:80: the machine answers, but nothing listens" in text
    assert re.search("fail    tcp/192.168.20.99:7447: (no answer|there is no way)", text), text
    assert away.code == 1


def test_it_reports_delays_and_whether_multicast_passes(lab: Lab) -> None:
    lab.network("eth0", table="192.168.10.10/24", laptop="192.168.10.20/24")
    wifi = lab.network("wlan0", table="192.168.11.10/24", phone="192.168.11.20/24")
    page = recipe("Wi-Fi that loses packets")
    page.files["table", "halo.toml"] += "multicast = true\n"
    page.write(lab)
    page.start(lab, "table").wait_for("ready")
    wifi.air = Air(loss=0.05, delay_s=0.01, multicast=False)
    good = doctor(lab, "laptop", "udp/192.168.10.10:7447")
    lossy = doctor(lab, "phone", "udp/192.168.11.10:7447")
    text = good.ended(60.0)
    assert "ok      multicast on eth0: works: peer at udp/192.168.10.10:7447" in text
    assert "fail" not in text
    assert good.code == 0
    text = lossy.ended(60.0)
    assert "multicast on wlan0: no answer" in text
    trip = re.search("note    round trip to udp/192.168.11.10:7447: ([0-9.]+) ms", text)
    assert trip is not None, text
    assert float(trip[1]) > 20.0
