"""The control port: what clients say to the service, by OSC over UDP.

Rule: every byte is distrusted. A bad datagram is counted, told once a sender, and skipped;
the receiver never throws and its queue has a bound.
"""

from __future__ import annotations

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
        """Bind the port. Raises `UserError` when it is taken."""
        self._queue: deque[Told] = deque(maxlen=QUEUE)
        self._strangers: set[tuple[str, int]] = set()
        self.bad = 0
        """Datagrams that were no OSC."""
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        try:
            self._socket.bind((host, port))
        except OSError as error:
            self._socket.close()
            raise UserError(
                f"control: port {port} on {host} cannot be opened ({error.strerror}); another halo "
                f"service may be running: end it, or choose another with --control-port"
            ) from error
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
