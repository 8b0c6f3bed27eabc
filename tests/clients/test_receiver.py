"""Messages on real carriers are received, counted and remembered."""

import logging
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from typing import Any

import pytest

import halo_client
from halo_client import ClientError, OscSource, Receiver
from halo_protocol import (
    DEFAULT_CONTROL_PORT,
    Event,
    Frame,
    Homography,
    Lost,
    Pointer,
    Report,
    TouchFrame,
    encode,
    encode_frame,
)

pytestmark = pytest.mark.slow


def receive_all(
    receiver: Receiver, until: Callable[[list[Event]], object], timeout_s: float = 10.0
) -> list[Event]:
    """Poll until `until(events so far)`."""
    events: list[Event] = []
    deadline = time.monotonic() + timeout_s
    while not until(events):
        assert time.monotonic() < deadline, f"still waiting; so far {events}"
        events += receiver.poll(0.05)
    return events


def frames_in(events: list[Event]) -> list[TouchFrame]:
    return [event for event in events if isinstance(event, TouchFrame)]


@pytest.fixture
def received(udp_service: Callable[..., Any]) -> Iterator[tuple[Receiver, Any]]:
    """A receiver on a free port and a service that sends there."""
    with halo_client.connect("osc://127.0.0.1:0") as receiver:
        yield receiver, udp_service(int(receiver.url.rpartition(":")[2]))


def test_a_tap_arrives_by_udp(received: tuple[Receiver, Any]) -> None:
    receiver, service = received
    service.tap()
    frames = frames_in(receive_all(receiver, lambda events: len(events) == 4))
    assert [len(frame.pointers) for frame in frames] == [1, 1, 1, 0]
    assert [down.contacts for frame in frames for down in frame.downs] == [1]
    assert [up.contacts for frame in frames for up in frame.ups] == [1]
    assert frames[1].pointers[0].touching
    assert frames[1].pointers[0].pressure == 0.625


def test_scene_and_health_are_remembered(received: tuple[Receiver, Any]) -> None:
    receiver, service = received
    service.scene()
    service.health()
    events = receive_all(receiver, lambda events: len(events) == 2)
    assert all(isinstance(event, Report) for event in events)
    assert receiver.services.scenes["desk", "table"].source == 2
    assert receiver.services.healths["desk", "table"].fps == 29.5


def test_a_homography_of_an_older_calibration_is_forgotten(received: tuple[Receiver, Any]) -> None:
    receiver, service = received
    of_revision = [Homography("desk", "s1", n, 1920, 1080, (1.0,) * 9) for n in (0, 7)]
    service.raw(encode("table", of_revision[0]))
    service.scene()
    receive_all(receiver, lambda events: len(events) == 2)
    assert receiver.services.homographies["desk", "table"] == of_revision[0]
    service.raw(encode("table", of_revision[1]))
    service.scene()
    receive_all(receiver, lambda events: len(events) == 2)
    assert ("desk", "table") not in receiver.services.homographies


def test_reports_of_many_services_do_not_fill_the_memory() -> None:
    services = halo_client.KnownServices()
    for number in range(1000):
        matrix = Homography(f"n{number}", "s1", 0, 1920, 1080, (1.0,) * 9)
        services.update(Report("table", matrix))
    assert len(services.homographies) == 64
    assert ("n999", "table") in services.homographies


def test_losses_are_counted(received: tuple[Receiver, Any]) -> None:
    receiver, service = received
    service.frame()
    service.lose()
    service.lose()
    service.frame()
    receive_all(receiver, lambda events: len(events) == 2)
    assert receiver.losses.missed == 2


def test_bad_datagrams_are_counted_logged_once_and_skipped(
    received: tuple[Receiver, Any], caplog: pytest.LogCaptureFixture
) -> None:
    receiver, service = received
    with caplog.at_level(logging.WARNING, "halo_client"):
        for _ in range(20):
            service.raw(b"nonsense")
        service.frame()
        receive_all(receiver, lambda events: len(events) == 1)
    assert receiver.losses.bad == 20
    assert [record.getMessage() for record in caplog.records] == [
        "skipping bad datagrams from 127.0.0.1: a string has no end: b'nonsense'"
    ]


def test_a_service_that_falls_silent_is_lost(received: tuple[Receiver, Any]) -> None:
    receiver, service = received
    service.scene()
    service.frame([])
    events = receive_all(receiver, lambda events: any(isinstance(e, Lost) for e in events))
    assert events[-1] == Lost("table", "desk", "s1")
    assert receiver.services.scenes == {}


def test_a_timeout_yields_none_so_that_a_picture_can_be_drawn(free_port: int) -> None:
    frames = halo_client.frames(f"osc://127.0.0.1:{free_port}", timeout_s=0.05)
    began_s = time.monotonic()
    assert [next(frames), next(frames)] == [None, None]
    assert time.monotonic() - began_s >= 0.1
    frames.close()


def test_a_closed_iterator_gives_its_port_back(
    free_port: int, udp_service: Callable[..., Any]
) -> None:
    frames = halo_client.frames(f"osc://127.0.0.1:{free_port}", timeout_s=0.01)
    assert next(frames) is None
    frames.close()
    with halo_client.connect(f"osc://127.0.0.1:{free_port}"):
        pass


def test_a_port_in_use_is_one_sentence_with_the_remedy(free_port: int) -> None:
    url = f"osc://127.0.0.1:{free_port}"
    with halo_client.connect(url), pytest.raises(ClientError) as refused:
        halo_client.connect(url)
    assert str(refused.value).startswith(f"UDP port {free_port} on 127.0.0.1 is in use")
    remedy = str(refused.value).split("'")[1]
    service = ("127.0.0.1", DEFAULT_CONTROL_PORT)
    assert halo_client.parse_source(remedy) == OscSource("", 0, hello=service)


def test_an_address_of_another_machine_is_one_sentence() -> None:
    with pytest.raises(ClientError, match=r"is 192\.0\.2\.1 an address of this machine"):
        halo_client.connect("osc://192.0.2.1:4256")


def test_closing_twice_is_fine(free_port: int) -> None:
    receiver = halo_client.connect(f"osc://127.0.0.1:{free_port}")
    receiver.close()
    receiver.close()


def test_a_udp_client_does_not_load_zenoh() -> None:
    program = (
        "import sys, halo_client; halo_client.connect('osc://127.0.0.1:0').close(); "
        "sys.exit('zenoh' in sys.modules)"
    )
    assert subprocess.run([sys.executable, "-c", program], timeout=30).returncode == 0


def test_a_tap_arrives_by_zenoh(zenoh_service: Callable[..., Any], free_tcp_port: int) -> None:
    endpoint = f"tcp/127.0.0.1:{free_tcp_port}"
    service = zenoh_service(endpoint)
    with halo_client.connect(f"zenoh://?connect={endpoint}") as receiver:
        connect(receiver, service)
        service.tap()
        frames = frames_in(receive_all(receiver, lambda e: len(frames_in(e)) == 4))
    assert [len(frame.pointers) for frame in frames] == [1, 1, 1, 0]
    assert [down.contacts for frame in frames for down in frame.downs] == [1]


def connect(receiver: Receiver, service: Any) -> None:
    """Send scenes until one arrives: then the subscription has found its publisher."""
    for _ in range(200):
        service.scene()
        if receiver.poll(0.05):
            break
    while receiver.poll(0.1):
        pass


def test_a_zenoh_service_may_start_later_and_anew(
    zenoh_service: Callable[..., Any], free_tcp_port: int
) -> None:
    endpoint = f"tcp/127.0.0.1:{free_tcp_port}"
    with halo_client.connect(f"zenoh://?connect={endpoint}") as receiver:
        assert receiver.poll(0.05) == []
        service = zenoh_service(endpoint)
        connect(receiver, service)
        service.close()
        again = zenoh_service(endpoint, session="s2")
        connect(receiver, again)
        again.frame()
        frames = frames_in(receive_all(receiver, lambda e: frames_in(e)))
    assert frames[-1].session == "s2"


def test_a_busy_zenoh_client_keeps_the_newest(
    zenoh_service: Callable[..., Any], free_tcp_port: int
) -> None:
    from halo_client.ring import RING

    endpoint = f"tcp/127.0.0.1:{free_tcp_port}"
    service = zenoh_service(endpoint)
    with halo_client.connect(f"zenoh://?connect={endpoint}") as receiver:
        connect(receiver, service)
        for _ in range(3 * RING):
            service.frame()
        service.scene()
        time.sleep(1.0)
        events = receive_all(receiver, lambda e: any(isinstance(event, Report) for event in e))
        assert len(frames_in(events)) < RING
        assert receiver.losses.missed == 0  # The first ones were before the client joined.


@pytest.mark.parametrize(
    ("url", "sentence"),
    [
        ("zenoh://?connect=nonsense", r"cannot use Zenoh with nonsense \(Endpoints must be"),
        ("zenoh://?listen=tcp/192.0.2.1:1", "cannot open Zenoh with tcp/192.0.2.1:1"),
    ],
)
def test_a_zenoh_endpoint_that_cannot_be_is_one_sentence(url: str, sentence: str) -> None:
    with pytest.raises(ClientError, match=sentence) as refused:
        halo_client.connect(url)
    assert "\n" not in str(refused.value)
    assert ".rs:" not in str(refused.value)


def from_services(*frames: tuple[str, str, int]) -> list[bytes]:
    """A frame with one finger per (node, session, number)."""
    return [
        encode_frame("table", Frame(node, session, number, number, 0, 1), [finger])[0]
        for node, session, number in frames
        for finger in [Pointer(1, 0, 2, 1, 0, 0.5, 0.5, 150, 100, 3, 0, 0, 0, 1, 0, -1)]
    ]


def sessions(receiver: Receiver, datagrams: list[bytes], service: Any) -> list[tuple[str, int]]:
    """(session, number of pointers) of the frames that are reported."""
    for datagram in datagrams:
        service.raw(datagram)
    events = [event for _ in datagrams for event in receiver.poll(0.5)]
    return [(frame.session, len(frame.pointers)) for frame in frames_in(events)]


def test_the_first_service_is_followed_and_others_are_named(
    received: tuple[Receiver, Any], caplog: pytest.LogCaptureFixture
) -> None:
    receiver, service = received
    datagrams = from_services(("desk", "s1", 1), ("wall", "s2", 1), ("desk", "s1", 2))
    with caplog.at_level(logging.WARNING, "halo_client"):
        assert sessions(receiver, datagrams, service) == [("s1", 1), ("s1", 1)]
    assert receiver.following == ("desk", "table", "s1")
    assert "also receives 'wall' on surface 'table', which is ignored" in caplog.text


@pytest.mark.parametrize(
    ("query", "followed"), [("?node=wall", ["s2"]), ("?follow=all", ["s1", "s2"])]
)
def test_another_service_can_be_followed_or_all(
    udp_service: Callable[..., Any], query: str, followed: list[str]
) -> None:
    with halo_client.connect(f"osc://127.0.0.1:0{query}") as receiver:
        service = udp_service(int(receiver.url.rpartition(":")[2]))
        datagrams = from_services(("desk", "s1", 1), ("wall", "s2", 1))
        assert [session for session, _ in sessions(receiver, datagrams, service)] == followed


def test_a_restarted_service_is_followed_at_once_and_its_old_finger_ends(
    received: tuple[Receiver, Any],
) -> None:
    receiver, service = received
    datagrams = from_services(("desk", "s1", 900), ("desk", "s2", 5), ("desk", "s2", 6))
    assert sessions(receiver, datagrams, service) == [("s1", 1), ("s1", 0), ("s2", 1), ("s2", 1)]


def test_of_two_services_with_one_name_the_newer_is_followed_and_it_is_reported(
    received: tuple[Receiver, Any], caplog: pytest.LogCaptureFixture
) -> None:
    receiver, service = received
    first = from_services(("desk", "s1", 1), ("desk", "s2", 1), ("desk", "s1", 2))
    assert sessions(receiver, first, service) == [("s1", 1), ("s1", 0), ("s2", 1)]
    with caplog.at_level(logging.WARNING, "halo_client"):
        for n in range(8):
            time.sleep(0.1)
            later = from_services(("desk", "s2", 2 + n), ("desk", "s1", 3 + n))
            assert sessions(receiver, later, service) == [("s2", 1)]
    assert receiver.losses.collisions == 1
    assert "two running services are called 'desk'" in caplog.text


def test_another_service_is_followed_after_the_first_is_lost(
    received: tuple[Receiver, Any],
) -> None:
    receiver, service = received
    assert sessions(receiver, from_services(("desk", "s1", 1)), service) == [("s1", 1)]
    receive_all(receiver, lambda events: any(isinstance(e, Lost) for e in events))
    assert sessions(receiver, from_services(("wall", "s2", 1)), service) == [("s2", 1)]
