"""A MIDI port that comes back after its synthesiser was restarted.

Rule: the port and nothing else; messages are arguments. The owner says what is sent first on each
connection, and last when the port is closed.
"""

from __future__ import annotations

import logging
import threading
from collections.abc import Callable, Iterable
from contextlib import suppress
from typing import Any, Protocol, Self

import mido

from halo_client.quiet import quiet
from halo_midi.errors import MidiError

log = logging.getLogger(__name__)

LOOK_S = 1.0
"""Time between two looks whether the port is still there."""
ERRORS = (OSError, ValueError, RuntimeError, SystemError)
"""What a port that died can raise: rtmidi's errors are of these kinds."""

Messages = Callable[[], Iterable[mido.Message]]


class Ports(Protocol):
    """What `mido` offers, or its substitute in a test."""

    def get_output_names(self) -> list[str]:
        """Return the names of the ports that are there now."""

    def open_output(self, name: str, *, virtual: bool = False) -> Any:
        """Open one, or create one that other programs see."""


class MidiPort:
    """An open port; a context manager. Raises `MidiError` when it is not there at the start."""

    def __init__(
        self,
        name: str,
        opening: Messages,
        closing: Messages,
        ports: Ports = mido,
        look_s: float = LOOK_S,
    ) -> None:
        """`name`: a part of the port's; `opening`: what to send at each connection, first."""
        self._name, self._ports, self._look_s = name, ports, look_s
        self._opening, self._closing = opening, closing
        self._lock = threading.Lock()
        try:
            names = self._names()
        except (ImportError, *ERRORS) as error:
            raise MidiError(f"MIDI is not available on this machine ({error})") from error
        match = self._match(names)
        if match is None:
            listed = ", ".join(names) or "none; start your sampler first"
            raise MidiError(f"no MIDI port is called {name!r}; available: {listed}")
        self._port: Any = None
        self._open_name = match
        self._open(match)
        self._closed = threading.Event()
        self._watcher = threading.Thread(target=self._watch, name="midi", daemon=True)
        self._watcher.start()

    def send(self, messages: Callable[[], Iterable[mido.Message]]) -> None:
        """Send what a function returns; nothing while the port is away.

        The function is called while no connection begins or ends, so that the notes it remembers
        are those of this connection.
        """
        with self._lock:
            self._send(messages())

    def close(self) -> None:
        """Send the last messages and close the port."""
        self._closed.set()
        self._watcher.join()
        with self._lock:
            self._send(self._closing())
            if self._port is not None:
                self._port.close()

    def _open(self, name: str) -> None:
        self._port, self._open_name = self._ports.open_output(name), name
        self._send(self._opening())

    def _send(self, messages: Iterable[mido.Message]) -> None:
        for message in messages:
            if self._port is None:
                return
            try:
                self._port.send(message)
            except ERRORS as error:
                self._lose(str(error))

    def _watch(self) -> None:
        """Look whether the port is there; most systems do not report that it went away."""
        while not self._closed.wait(self._look_s):
            try:
                names = self._names()
                with self._lock:
                    self._look(names)
            except ERRORS as error:
                log.debug("midi: %s", error)

    def _look(self, names: list[str]) -> None:
        if self._port is not None and self._open_name not in names:
            self._lose("it is gone")
        match = self._match(names)
        if self._port is None and match is not None:
            self._open(match)
            log.warning("midi: the port %s is back", match)

    def _lose(self, reason: str) -> None:
        log.warning("midi: the port %s is lost (%s); waiting for it", self._open_name, reason)
        port, self._port = self._port, None
        with suppress(*ERRORS):
            port.close()

    def _names(self) -> list[str]:
        with quiet():
            return list(self._ports.get_output_names())

    def _match(self, names: list[str]) -> str | None:
        return next((port for port in names if self._name.lower() in port.lower()), None)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


class OwnPort:
    """A port that this program creates and others connect to; a context manager.

    Raises `MidiError` where the system has no such ports.
    """

    def __init__(
        self, name: str, opening: Messages, closing: Messages, ports: Ports = mido
    ) -> None:
        """`name`: what other programs show; `opening`: what to send first."""
        self._closing, self._failed = closing, False
        try:
            with quiet():
                self._port = ports.open_output(name, virtual=True)
        except (ImportError, NotImplementedError, *ERRORS) as error:
            raise MidiError(
                f"no MIDI port can be created on this machine ({error}); name one that exists "
                "with --port (on Windows, of loopMIDI), or try --print, which needs none"
            ) from error
        self.send(opening)

    def send(self, messages: Messages) -> None:
        """Send what a function returns; the first message that fails is logged."""
        for message in messages():
            try:
                self._port.send(message)
            except ERRORS as error:
                if not self._failed:
                    log.warning("midi: a message was not sent (%s)", error)
                self._failed = True

    def close(self) -> None:
        """Send the last messages and remove the port."""
        self.send(self._closing)
        self._port.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()
