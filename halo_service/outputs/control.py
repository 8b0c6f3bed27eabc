"""The control port: what clients say to the service, by OSC over UDP.

Rule: every byte is distrusted. A bad datagram is counted, told once a sender, and skipped;
the receiver never throws and its queue has a bound.
"""

from __future__ import annotations

import errno
import logging
import socket
import threading
from collections import deque
from typing import NamedTuple

import halo_protocol as wire
from halo_service.errors import UserError

log = logging.getLogger(__name__)

QUEUE = 256
"""Messages kept until the service takes them; the oldest go first."""
SENDERS = 64
"""Senders of bad datagrams remembered, so that each is told of once."""
PORTS = range(1, 65_536)
"""Ports that UDP has; 0 would be one that no client knows."""
WAKE_S = 0.2
"""How often the receiver looks whether it shall end."""


class Told(NamedTuple):
    """One message from a client."""

    address: str
    arguments: tuple[wire.Argument, ...]
    sender: tuple[str, int]


class ControlPort:
    """Receives in a thread of its own; the service takes messages when it has time."""

    def __init__(self, host: str, port: int) -> None:
        """Bind the port. Raises `UserError` when it is none, taken, or the host is not ours."""
        if port not in PORTS:
            raise UserError(
                f"control: {port} is no port; choose one from {PORTS[0]} to {PORTS[-1]} with "
                f"--control-port"
            )
        self._queue: deque[Told] = deque(maxlen=QUEUE)
        self._strangers: set[tuple[str, int]] = set()
        self.bad = 0
        """Datagrams that were no OSC."""
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        try:
            self._socket.bind((host, port))
        except OSError as error:
            self._socket.close()
            raise _refused(host, port, error) from error
        self._socket.settimeout(WAKE_S)
        self._ended = threading.Event()
        self._thread = threading.Thread(target=self._receive, name="control", daemon=True)
        self._thread.start()

    def take(self) -> list[Told]:
        """Return what has come since the last call, oldest first."""
        taken = []
        while self._queue:
            taken.append(self._queue.popleft())
        return taken

    def close(self) -> None:
        """End the receiver and let the port go."""
        self._ended.set()
        self._thread.join()
        self._socket.close()

    def _receive(self) -> None:
        while not self._ended.is_set():
            try:
                datagram, sender = self._socket.recvfrom(65_536)
            except TimeoutError:
                continue
            except OSError as error:  # Windows reports a receiver that went away here
                log.debug("control: %s", error)
                continue
            self._read(datagram, sender)

    def _read(self, datagram: bytes, sender: tuple[str, int]) -> None:
        try:
            messages = wire.parse_osc(datagram)
        except wire.ProtocolError as error:
            self.bad += 1
            if sender not in self._strangers and len(self._strangers) < SENDERS:
                self._strangers.add(sender)
                log.warning("control: skipped a datagram from %s:%d: %s", *sender, error)
            return
        self._queue.extend(Told(address, arguments, sender) for address, arguments in messages)


def _refused(host: str, port: int, error: OSError) -> UserError:
    """Say which of the two the system did not like: the port, or the host."""
    if isinstance(error, socket.gaierror) or error.errno == errno.EADDRNOTAVAIL:
        remedy = "set [control] host to an address of this machine, such as 127.0.0.1"
    elif error.errno == errno.EADDRINUSE:
        remedy = (
            "another halo service may be running: end it, or choose another with --control-port"
        )
    else:
        remedy = "choose another with --control-port"
    return UserError(
        f"control: port {port} on {host} cannot be opened ({error.strerror}); {remedy}"
    )
