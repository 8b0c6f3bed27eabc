"""Services are found by name on the loopback, and only where their ports are open."""

from __future__ import annotations

import secrets
import subprocess
import sys
import time
from contextlib import ExitStack, closing

import pytest
from zeroconf import IPVersion, ServiceInfo, Zeroconf

from halo_service.outputs.name_watch import NameWatch
from halo_service.web.announcement import OSC, OSCQUERY, Announcement, Port, _addresses

pytestmark = pytest.mark.slow

PATIENCE_S = 15.0
RUN = secrets.token_hex(4)
"""Part of the names: others on this machine may run these tests, too."""


def found(kind: str) -> ServiceInfo | None:
    with closing(Zeroconf(interfaces=["127.0.0.1"], ip_version=IPVersion.V4Only)) as browser:
        until = time.monotonic() + PATIENCE_S
        info = None
        while info is None and time.monotonic() < until:
            info = browser.get_service_info(kind, f"halo-test-{RUN}.{kind}", timeout=1000)
        return info


def test_a_service_is_found_by_name_until_it_ends() -> None:
    ports = [Port(OSC, "127.0.0.1", 4257), Port(OSCQUERY, "127.0.0.1", 4258)]
    facts = {"surface": "table", "rate_hz": "30"}
    with closing(Announcement(NameWatch(f"halo-test-{RUN}", "s1"), ports, facts)) as announced:
        for kind, _, number in ports:
            info = found(kind)
            assert info is not None
            assert (info.port, info.parsed_addresses()) == (number, ["127.0.0.1"])
            assert info.decoded_properties == {"node": f"halo-test-{RUN}", "session": "s1", **facts}
        announced.update(rate_hz="15")
        announced._thread.join()
        info = found(OSC)
        assert info is not None
        assert info.decoded_properties["rate_hz"] == "15"
    with closing(Zeroconf(interfaces=["127.0.0.1"], ip_version=IPVersion.V4Only)) as browser:
        assert browser.get_service_info(OSC, f"halo-test-{RUN}.{OSC}", timeout=500) is None


@pytest.mark.parametrize(
    ("host", "addresses"),
    [
        ("127.0.0.1", ["127.0.0.1"]),
        ("localhost", ["127.0.0.1"]),
        ("192.0.2.7", ["192.0.2.7"]),
        ("::1", []),
        ("table.local", []),
    ],
)
def test_only_addresses_that_are_open_are_announced(host: str, addresses: list[str]) -> None:
    assert _addresses(host) == addresses


def test_an_open_service_is_announced_under_every_address_but_the_loopback() -> None:
    assert "127.0.0.1" not in _addresses("0.0.0.0")


def test_what_cannot_be_announced_costs_a_line(caplog: pytest.LogCaptureFixture) -> None:
    too_long = f"halo-test-{RUN}" * 10
    with closing(Announcement(NameWatch(too_long, "s1"), [Port(OSC, "127.0.0.1", 1)], {})):
        pass
    assert "other programs cannot find this service by name" in caplog.text


@pytest.fixture
def quick(monkeypatch: pytest.MonkeyPatch) -> None:
    """Others are asked often, and a collision is soon over."""
    monkeypatch.setattr("halo_service.web.name_search.LOOK_S", 0.2)
    monkeypatch.setattr("halo_service.outputs.name_watch.LASTS_S", 1.0)


def wait_for(collides: bool, *watches: NameWatch) -> None:
    until = time.monotonic() + PATIENCE_S
    while any(watch.collision(time.monotonic()) != collides for watch in watches):
        assert time.monotonic() < until, f"collision is not {collides}"
        time.sleep(0.05)


def test_two_services_of_one_name_notice_each_other_until_one_ends(
    caplog: pytest.LogCaptureFixture, quick: None
) -> None:
    first, second = (NameWatch(f"halo-twin-{RUN}", each) for each in ("s1", "s2"))
    other = NameWatch(f"halo-other-{RUN}", "s3")
    with ExitStack() as stack:
        for number, names in enumerate((first, other)):
            port = Port(OSC, "127.0.0.1", 5000 + number)
            started = stack.enter_context(closing(Announcement(names, [port], {})))
            started._thread.join()
        with closing(Announcement(second, [Port(OSC, "127.0.0.1", 5002)], {})):
            wait_for(True, first, second)
        assert not other.collision(time.monotonic())
        wait_for(False, first)
    assert caplog.text.count(f"also called 'halo-twin-{RUN}' (session s2)") == 1
    assert caplog.text.count(f"also called 'halo-twin-{RUN}' (session s1)") == 1


def test_announcements_of_other_programs_are_ignored(quick: None) -> None:
    names = NameWatch(f"halo-alone-{RUN}", "s1")
    with (
        closing(Announcement(names, [Port(OSC, "127.0.0.1", 5000)], {})) as ours,
        closing(Zeroconf(interfaces=["127.0.0.1"], ip_version=IPVersion.V4Only)) as program,
    ):
        ours._thread.join()
        (search,) = ours._searches
        facts = {"node": f"halo-alone-{RUN}", "session": "\n", "surface": b"\xff"}
        info = ServiceInfo(
            OSC,
            f"halo-alone-{RUN}-2.{OSC}",
            port=1,
            parsed_addresses=["127.0.0.1"],
            properties=facts,
        )
        program.register_service(info)
        until = time.monotonic() + PATIENCE_S
        while f"halo-alone-{RUN}-2.{OSC}" not in search._found:
            assert time.monotonic() < until
            time.sleep(0.05)
        time.sleep(1.0)
        assert search._thread.is_alive()
        assert not names.collision(time.monotonic())


TWIN = """
import sys, time
from halo_service.outputs.name_watch import NameWatch
from halo_service.web import announcement

announcement.LASTS_S = 2
port = announcement.Port(announcement.OSC, "127.0.0.1", 5001)
twin = announcement.Announcement(NameWatch(sys.argv[1], "s2"), [port], {})
time.sleep(60.0)
"""


def test_a_service_that_was_killed_is_forgotten(quick: None) -> None:
    names = NameWatch(f"halo-killed-{RUN}", "s1")
    with closing(Announcement(names, [Port(OSC, "127.0.0.1", 5000)], {})):
        twin = subprocess.Popen([sys.executable, "-c", TWIN, names.node])
        wait_for(True, names)
        twin.kill()  # no goodbye
        twin.wait()
        wait_for(False, names)
