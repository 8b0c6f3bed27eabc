"""The control port: receives messages from clients, as OSC over UDP.

Rule: trust no byte. A bad datagram is counted, logged once per sender and skipped; the
receiver never raises and its queue is bounded.
"""

from __future__ import annotations

import errno
import logging
import socket
import threading
from collections import deque
from collections.abc import Callable
from functools import partial
from typing import NamedTuple

import halo_protocol as wire
from halo_protocol.osc import message_spans
from halo_service.errors import UserError

log = logging.getLogger(__name__)

QUEUE = 256
"""Messages that wait for the service; when it is full, the oldest is dropped."""
SENDERS = 64
"""Senders of bad datagrams that are remembered, so that each is logged once."""
PORTS = range(1, 65_536)
"""Valid UDP ports; 0 would be a random one that no client can know."""
WAKE_S = 0.2
"""How often the receiver checks whether it should end."""


def _no_answer(datagram: bytes) -> None:
    """The default for `answer`."""


class ControlMessage(NamedTuple):
    """One message from a client."""

    address: str
    arguments: tuple[wire.Argument, ...]
    sender: tuple[str, int]
    size: int = 0
    """Bytes of the message, without those of others in its bundle; an answer must not be larger."""
    answer: Callable[[bytes], None] = _no_answer
    """Sends one OSC message back."""


class ControlPort:
    """Receives in its own thread; the service drains messages between frames."""

    def __init__(self, host: str, port: int) -> None:
        """Bind the port, or a free one where it is in use.

        Raises `UserError` for an invalid port, or a host that is not an address of this machine.
        """
        if port not in PORTS:
            raise UserError(
                f"control: {port} is not a port; choose one from {PORTS[0]} to {PORTS[-1]} with "
                f"--control-port"
            )
        self._queue: deque[ControlMessage] = deque(maxlen=QUEUE)
        self._strangers: set[tuple[str, int]] = set()
        self.bad = 0
        """Datagrams that were not OSC."""
        self._socket = _bound(host, port)
        self.port = int(self._socket.getsockname()[1])
        """The port that it uses."""
        if self.port != port:
            log.warning(
                "control: port %d is in use, so this service uses %d; clients find it in 'scene'",
                port,
                self.port,
            )
        self._socket.settimeout(WAKE_S)
        self._ended = threading.Event()
        self._thread = threading.Thread(target=self._receive, name="control", daemon=True)
        self._thread.start()

    def drain(self) -> list[ControlMessage]:
        """Return the messages received since the last call, oldest first."""
        messages = []
        while self._queue:
            messages.append(self._queue.popleft())
        return messages

    def put(self, message: ControlMessage) -> None:
        """Queue a message that came another way; from any thread."""
        self._queue.append(message)

    def reply(self, datagram: bytes, to: tuple[str, int]) -> None:
        """Send a small answer; what cannot be sent now is dropped."""
        try:
            self._socket.sendto(datagram, to)
        except OSError as error:
            log.debug("control: no answer to %s:%d: %s", *to[:2], error)

    def close(self) -> None:
        """End the receiver and close the port."""
        self._ended.set()
        self._thread.join()
        self._socket.close()

    def _receive(self) -> None:
        while not self._ended.is_set():
            try:
                datagram, sender = self._socket.recvfrom(65_536)
            except TimeoutError:
                continue
            except (
                OSError
            ) as error:  # Windows reports here that an earlier receiver closed its port
                log.debug("control: %s", error)
                continue
            self._read(datagram, sender[:2])

    def _read(self, datagram: bytes, sender: tuple[str, int]) -> None:
        try:
            messages = wire.parse_osc(datagram)
            sizes = [end - start for start, end in message_spans(datagram)]
        except wire.ProtocolError as error:
            self.bad += 1
            if sender not in self._strangers and len(self._strangers) < SENDERS:
                self._strangers.add(sender)
                log.warning("control: skipped a datagram from %s:%d: %s", *sender, error)
            return
        answer = partial(self.reply, to=sender)
        self._queue.extend(
            ControlMessage(address, arguments, sender, size, answer)
            for (address, arguments), size in zip(messages, sizes, strict=True)
        )


def _bound(host: str, port: int) -> socket.socket:
    """Open a socket on the port, or on a free one where it is in use or needs rights."""
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    control = socket.socket(family, socket.SOCK_DGRAM)
    try:
        try:
            control.bind((host, port))
        except OSError as error:
            if error.errno not in (errno.EADDRINUSE, errno.EACCES):
                raise
            control.bind((host, 0))
    except OSError as error:
        control.close()
        raise UserError(
            f"control: port {port} on {host} cannot be opened ({error.strerror}); set [control] "
            f"host to an address of this machine, such as 127.0.0.1"
        ) from error
    return control
