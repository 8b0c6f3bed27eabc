"""Starts the service, the router and a client, ends them, and watches what the client receives."""

from __future__ import annotations

import multiprocessing
import os
import resource
import socket
import time
from collections.abc import Callable
from contextlib import ExitStack
from multiprocessing.connection import Connection
from multiprocessing.context import SpawnProcess
from pathlib import Path

import halo_client
from halo_protocol.osc import padded
from halo_service.profile.store import save
from tests.faults import profile
from tests.ports import free_port

from .client import Seen
from .service import route, serve


class Running:
    """The service, the router, and the client, from `__init__` until `stack` ends them."""

    def __init__(self, folder: Path, stack: ExitStack) -> None:
        self.folder = folder
        self._ports = {name: free_port() for name in ("osc", "control", "router", "web")}
        self._context = multiprocessing.get_context("spawn")
        save(profile(), folder / "profile")
        self.start_router()
        stack.callback(self.kill_router)
        self.start()
        stack.callback(self.kill)
        url = f"osc://127.0.0.1:{self._ports['osc']}"
        self._receiver = stack.enter_context(halo_client.connect(url, everything=True))
        self.seen = Seen()

    def watch(self, seconds: float, until: Callable[[], bool] = lambda: False) -> None:
        """Receive for a while, or until something is seen."""
        end_s = time.monotonic() + seconds
        while True:
            for event in self._receiver.poll(0.02):
                self.seen.update(event, time.monotonic())
            if time.monotonic() >= end_s or until():
                return

    # ---- the service

    def start(self) -> None:
        """Start the service."""
        self._pipe, theirs = self._context.Pipe()
        arguments: tuple[Path, dict[str, int], Connection] = (self.folder, self._ports, theirs)
        self._service = self._context.Process(target=serve, args=arguments, daemon=True)
        self._service.start()
        theirs.close()

    @property
    def alive(self) -> bool:
        """Whether the service runs."""
        return self._service.is_alive()

    def kill(self) -> None:
        """Kill the service, and wait for its end."""
        _kill(self._service)

    def send_signal(self, number: int) -> None:
        """Send a signal to the service."""
        os.kill(self._service.pid or 0, number)

    def order(self, order: str, fault: str) -> None:
        """Begin or end a fault in the service."""
        self._pipe.send((order, fault))
        self.watch(5.0, self._pipe.poll)
        self._pipe.recv()

    def control(self, address: str) -> None:
        """Send a message to the service's control port."""
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender:
            sender.sendto(padded(address) + padded(","), ("127.0.0.1", self._ports["control"]))

    def usage(self) -> tuple[float, int]:
        """Return the service's memory in MB and its open files."""
        process = Path("/proc") / str(self._service.pid)
        pages = int((process / "statm").read_text().split()[1])
        return pages * resource.getpagesize() / 1e6, len(list((process / "fd").iterdir()))

    # ---- the router, and further clients

    def start_router(self) -> None:
        """Start the Zenoh router."""
        self._router: SpawnProcess = self._context.Process(
            target=route, args=(self._ports["router"],), daemon=True
        )
        self._router.start()

    def kill_router(self) -> None:
        """Kill the router, and wait for its end."""
        _kill(self._router)

    def routes(self) -> bool:
        """Return whether the router listens."""
        with socket.socket() as probe:
            return probe.connect_ex(("127.0.0.1", self._ports["router"])) == 0

    def client_of_the_router(self) -> halo_client.Receiver:
        """Connect a client to the router."""
        endpoint = f"tcp/127.0.0.1:{self._ports['router']}"
        return halo_client.connect(f"zenoh://?mode=client&connect={endpoint}")

    def client_that_asks(self) -> halo_client.Receiver:
        """Connect a client that asks the service for its stream."""
        return halo_client.connect(f"osc://?hello=127.0.0.1:{self._ports['control']}")


def _kill(process: SpawnProcess) -> None:
    process.kill()
    process.join()
