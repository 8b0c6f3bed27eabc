"""The drums as MIDI, so that any sampler can be the sound.

Rule: `messages` is pure; only `MidiOut` touches a port. Channel 10 and General MIDI's notes, so
that most samplers play the right drum without settings.
"""

from __future__ import annotations

import logging
import threading
from contextlib import suppress
from typing import Any, Protocol, Self

import mido

from halo_drums.errors import MidiError
from halo_drums.player import Gesture, Hit, Release, Shape
from halo_drums.quiet import quiet

log = logging.getLogger(__name__)

LOOK_S = 1.0
"""Time between two looks whether the port is still there."""
ERRORS = (OSError, ValueError, RuntimeError, SystemError)
"""What a port that died can raise: rtmidi's errors are of these kinds."""
CHANNEL = 9
"""MIDI channel 10, counted from 0."""
BRIGHTNESS = 74
"""Controller 74, "brightness" in most synthesizers: the height of the hovering hand."""


class Notes:
    """Remembers the note of each touch."""

    def __init__(self) -> None:
        self._held: dict[object, int] = {}

    def messages(self, gesture: Gesture) -> list[mido.Message]:
        """Return the MIDI messages of a gesture."""
        if isinstance(gesture, Hit):
            self._held[gesture.key] = gesture.pad.note
            return [_message("note_on", note=gesture.pad.note, velocity=_seven(gesture.level))]
        if isinstance(gesture, Shape):
            value = _seven(gesture.height)
            return [_message("control_change", control=BRIGHTNESS, value=value)]
        note = self._held.get(gesture.key)
        if note is None:
            return []
        if isinstance(gesture, Release):
            del self._held[gesture.key]
            return [_message("note_off", note=note)]
        return [_message("polytouch", note=note, value=_seven(min(gesture.amount, 1.0)))]


class Ports(Protocol):
    """What `mido` offers, or its substitute in a test."""

    def get_output_names(self) -> list[str]:
        """Return the names of the ports that are there now."""

    def open_output(self, name: str) -> Any:
        """Open one."""


class MidiOut:
    """A port that comes back after its sampler was restarted; a context manager.

    Raises `MidiError` when it is not there at the start.
    """

    def __init__(self, name: str, ports: Ports = mido, look_s: float = LOOK_S) -> None:
        """`name`: a part of the port's; `look_s`: time between two looks for it."""
        self._name, self._ports, self._look_s = name, ports, look_s
        self._lock = threading.Lock()
        self._notes = Notes()
        try:
            names = self._names()
        except (ImportError, OSError, SystemError) as error:
            raise MidiError(f"MIDI is not available on this machine ({error})") from error
        match = self._match(names)
        if match is None:
            listed = ", ".join(names) or "none; start your sampler first"
            raise MidiError(f"no MIDI port is called {name!r}; available: {listed}")
        self._port: Any = ports.open_output(match)
        self._open_name = match
        self._closed = threading.Event()
        self._watcher = threading.Thread(target=self._watch, name="midi", daemon=True)
        self._watcher.start()

    def send(self, gesture: Gesture) -> None:
        """Send a gesture; nothing while the port is away."""
        with self._lock:
            for message in self._notes.messages(gesture):
                if self._port is not None:
                    try:
                        self._port.send(message)
                    except ERRORS as error:
                        self._lose(str(error))

    def close(self) -> None:
        """End all notes and close the port."""
        self._closed.set()
        self._watcher.join()
        if self._port is not None:
            self._port.reset()
            self._port.close()

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
            self._port, self._open_name = self._ports.open_output(match), match
            self._notes = Notes()
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


def _message(kind: str, **values: int) -> mido.Message:
    return mido.Message(kind, channel=CHANNEL, **values)


def _seven(value: float) -> int:
    """Convert 0..1 to MIDI's 1..127; a velocity of 0 would end the note."""
    return max(1, min(127, round(127 * value)))
