"""A service to receive from: encoded frames on a real carrier."""

import json
import socket
import threading
import time
from collections.abc import Callable, Iterator, Sequence

import pytest
import zenoh

from halo_protocol import (
    Down,
    Frame,
    Health,
    Pointer,
    Scene,
    Up,
    encode,
    encode_frame,
    first_frame,
    next_frame,
    zenoh_key,
)
from tests import ports

RIGHT, INDEX, HOVER, TOUCH = 2, 1, 0, 1


class Service:
    """Sends frames, one after the other, with `send(kind, datagram)`."""

    def __init__(self, send: Callable[[str, bytes], object], session: str = "s1") -> None:
        self._send = send
        self._session = session
        self.close: Callable[[], object] = lambda: None
        self._frame = first_frame(time.time_ns() // 1000)

    def frame(
        self, pointers: Sequence[Pointer] = (), downs: Sequence[Down] = (), ups: Sequence[Up] = ()
    ) -> None:
        time_us = time.time_ns() // 1000
        header = Frame(
            "desk", self._session, self._frame, *divmod(time_us, 1_000_000), len(pointers)
        )
        for datagram in encode_frame("table", header, pointers, downs, ups):
            self._send("frame", datagram)
        self._frame = next_frame(self._frame)

    def lose(self) -> None:
        self._frame = next_frame(self._frame)

    def scene(self, source: int = 2, calibration: int = 1) -> None:
        scene = Scene("desk", self._session, "1.0.0", 300.0, 200.0, calibration, 0, source, 30.0)
        self._send("scene", encode("table", scene))

    def health(self) -> None:
        health = Health("desk", self._session, 29.5, 3.25, 1, 2, 3, 1, 33.0)
        self._send("health", encode("table", health))

    def raw(self, datagram: bytes) -> None:
        self._send("frame", datagram)

    def tap(self) -> None:
        """A finger hovers, touches and leaves."""
        self.frame([finger()])
        self.frame([finger(TOUCH, 1)], [Down(1, 0, 0.3, 0.5, 210.0, 12.0, 1)])
        self.frame([finger(HOVER, 1)], (), [Up(1, 0, 0.3, 0.5, 3.0, 1)])
        self.frame()


def finger(state: int = HOVER, contacts: int = 0) -> Pointer:
    hover_mm = 0.0 if state == TOUCH else 4.5
    pressure = 0.625 if state == TOUCH else 0.0
    place = (0.3, 0.5, 90.0, 100.0, hover_mm, pressure, 0.0, 0.0, 0.875)
    return Pointer(1, 0, RIGHT, INDEX, state, *place, contacts, -1.0)


@pytest.fixture
def udp_service() -> Iterator[Callable[..., Service]]:
    """`udp_service(port)` -> a service that sends there."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender:

        def to(port: int, **settings: str) -> Service:
            return Service(lambda _, raw: sender.sendto(raw, ("127.0.0.1", port)), **settings)

        yield to


@pytest.fixture
def free_port() -> int:
    return ports.free_port()


@pytest.fixture
def free_tcp_port() -> int:
    return ports.free_port()


@pytest.fixture
def zenoh_service() -> Iterator[Callable[..., Service]]:
    """`zenoh_service(endpoint)` -> a service on a peer of its own, closed at the end."""
    sessions = []

    def at(endpoint: str, mode: str = "peer", connect: str = "", **settings: str) -> Service:
        config = zenoh.Config()
        config.insert_json5("mode", json.dumps(mode))
        config.insert_json5("listen/endpoints", json.dumps([endpoint]))
        config.insert_json5("connect/endpoints", json.dumps([connect] if connect else []))
        config.insert_json5("scouting/multicast/enabled", "false")
        session = zenoh.open(config)
        sessions.append(session)

        def send(kind: str, datagram: bytes) -> None:
            session.put(zenoh_key("desk", "table", kind), datagram)

        service = Service(send, **settings)
        service.close = session.close
        return service

    yield at
    for session in sessions:
        session.close()


@pytest.fixture
def repeat() -> Iterator[Callable[[Callable[[], object]], None]]:
    """`repeat(action)` calls it 50 times a second until the test ends."""
    over = threading.Event()
    threads = []

    def start(action: Callable[[], object]) -> None:
        def run() -> None:
            while not over.wait(0.02):
                action()

        threads.append(threading.Thread(target=run))
        threads[-1].start()

    yield start
    over.set()
    for thread in threads:
        thread.join()
