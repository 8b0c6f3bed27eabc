"""Services of one machine have a port each, and programs receive all of them."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, closing
from dataclasses import replace

import pytest

import halo_protocol as wire
from halo_client import Follow, ZenohSource
from halo_client.zenoh_input import ZenohInput
from halo_service.errors import UserError
from halo_service.outputs import zenoh_port
from halo_service.outputs.outgoing import OutgoingReport
from halo_service.outputs.settings import ZenohSettings
from halo_service.outputs.zenoh import ZenohOutput

SCENE = wire.Scene("desk", "s1", "1.0.0", 300.0, 200.0, 2, 0, 0, 30.0)
WAIT_S = 20.0


@pytest.fixture
def ports(free_port: Callable[[], int], monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """The default ports, in place of those that a service of this machine may use."""
    ports = [free_port() for _ in range(3)]
    monkeypatch.setattr(zenoh_port, "PORTS", ports)
    return ports


@pytest.fixture
def stack() -> Iterator[ExitStack]:
    with ExitStack() as stack:
        yield stack


def service(stack: ExitStack, node: str, settings: ZenohSettings) -> ZenohOutput:
    return stack.enter_context(closing(ZenohOutput(settings, node, "table")))


def test_a_program_at_the_usual_port_receives_all_services_of_the_machine(
    ports: list[int], stack: ExitStack, caplog: pytest.LogCaptureFixture
) -> None:
    services = {name: service(stack, name, ZenohSettings()) for name in ("left", "right", "third")}
    assert [each.listen for each in services.values()] == [(f"tcp/127.0.0.1:{p}",) for p in ports]
    said = [each.getMessage() for each in caplog.records]
    assert said == [
        f"zenoh: port {ports[0]} is in use, so this service uses {port}" for port in ports[1:]
    ]
    source = ZenohSource((f"tcp/127.0.0.1:{ports[0]}",), follow=Follow(wire.ANY))
    client = stack.enter_context(ZenohInput(source))
    received: set[str] = set()
    until = time.monotonic() + WAIT_S
    while received != {f"halo/1/{name}/table/scene" for name in services}:
        assert time.monotonic() < until, received
        for name, each in services.items():
            each.send(OutgoingReport("table", replace(SCENE, node=name)))
        while (sample := client.receive(0.05)) is not None:
            received.add(sample[1])


def test_the_end_of_the_first_service_is_no_fault_of_the_second(
    ports: list[int], stack: ExitStack
) -> None:
    with closing(ZenohOutput(ZenohSettings(), "left", "table")):
        second = service(stack, "right", ZenohSettings())
        assert second.missing == 0
    assert second.missing == 0


@pytest.mark.parametrize("host", ["127.0.0.1", "localhost", "[::1]"])
def test_the_port_of_a_service_that_starts_later_stays_free(
    host: str, ports: list[int], stack: ExitStack, caplog: pytest.LogCaptureFixture
) -> None:
    there = service(stack, "there", ZenohSettings(connect=(f"tcp/{host}:{ports[0]}",)))
    assert there.listen == (f"tcp/127.0.0.1:{ports[1]}",)
    assert "is in use" not in caplog.text
    elsewhere = service(stack, "elsewhere", ZenohSettings(connect=(f"tcp/127.0.0.1:{ports[2]}",)))
    assert elsewhere.listen == (f"tcp/127.0.0.1:{ports[0]}",)


def test_a_service_that_was_faster_gets_the_port(
    ports: list[int], stack: ExitStack, monkeypatch: pytest.MonkeyPatch
) -> None:
    service(stack, "left", ZenohSettings())
    free, asked = zenoh_port._is_free, list[int]()

    def is_free(port: int) -> bool:
        asked.append(port)
        return asked == [ports[0]] or free(port)

    monkeypatch.setattr(zenoh_port, "_is_free", is_free)
    assert service(stack, "right", ZenohSettings()).listen == (f"tcp/127.0.0.1:{ports[1]}",)


def test_without_a_free_port_the_remedy_is_named(
    ports: list[int], stack: ExitStack, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(zenoh_port, "PORTS", ports[:1])
    service(stack, "left", ZenohSettings())
    with pytest.raises(UserError, match=r"are in use; set \[zenoh\] listen"):
        service(stack, "right", ZenohSettings())
