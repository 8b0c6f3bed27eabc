"""The drums as MIDI, so that any sampler can be the sound.

Rule: `Notes` is pure; `halo_midi.port` is the port. Channel 10 and General MIDI's notes, so
that most samplers play the right drum without settings.
"""

from __future__ import annotations

from typing import Self

import mido

from halo_drums.player import Gesture, Hit, Release, Shape
from halo_midi.port import LOOK_S, MidiPort, Ports

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


class MidiOut:
    """The drums on a MIDI port; a context manager. Raises `MidiError` without the port."""

    def __init__(self, name: str, ports: Ports = mido, look_s: float = LOOK_S) -> None:
        """`name`: a part of the port's; `look_s`: time between two looks for it."""
        self._notes = Notes()
        self._port = MidiPort(name, self._opening, mido.ports.reset_messages, ports, look_s)

    def send(self, gesture: Gesture) -> None:
        """Send a gesture; nothing while the port is away."""
        self._port.send(lambda: self._notes.messages(gesture))

    def close(self) -> None:
        """End all notes and close the port."""
        self._port.close()

    def _opening(self) -> list[mido.Message]:
        """A sampler that was restarted sounds no note."""
        self._notes = Notes()
        return []

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


def _message(kind: str, **values: int) -> mido.Message:
    return mido.Message(kind, channel=CHANNEL, **values)


def _seven(value: float) -> int:
    """Convert 0..1 to MIDI's 1..127; a velocity of 0 would end the note."""
    return max(1, min(127, round(127 * value)))
