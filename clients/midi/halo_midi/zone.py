"""Which member channel each finger has.

Rule: pure. The lower zone of MPE: channel 1 is the master, 2 to 16 are the members. Channels are
counted from 0 here, as in MIDI's bytes. A finger that hovers near the surface reserves a channel,
so that its values are there before its note.
"""

from __future__ import annotations

from collections.abc import Hashable
from dataclasses import dataclass, field
from typing import Generic, TypeVar

MASTER = 0
MOST_MEMBERS = 15

Finger = TypeVar("Finger", bound=Hashable)


@dataclass(slots=True)
class Zone(Generic[Finger]):
    """The member channels; each has one finger or none."""

    members: int
    _free: list[int] = field(default_factory=list)
    """In the order in which they became free, so that a released note can ring longest."""
    _reserved: dict[Finger, int] = field(default_factory=dict)
    _sounding: dict[Finger, int] = field(default_factory=dict)
    """Both in the order in which the fingers came."""

    def __post_init__(self) -> None:
        self._free = list(range(1, self.members + 1))

    def reserve(self, finger: Finger) -> int | None:
        """Return the channel of a hovering finger; None if all channels are used."""
        if finger not in self._reserved:
            if not self._free:
                return None
            self._reserved[finger] = self._free.pop(0)
        return self._reserved[finger]

    def cancel(self, finger: Finger) -> None:
        """A hovering finger is gone. Its channel had no note, so it is the next to be used."""
        channel = self._reserved.pop(finger, None)
        if channel is not None:
            self._free.insert(0, channel)

    def start(self, finger: Finger) -> tuple[int, Finger | None]:
        """Return the channel of a note, and the finger that loses its note for it.

        Its own reserved channel; else the one that is free for the longest time; else one that
        hovers; else that of the oldest note.
        """
        stolen = None
        if finger in self._reserved:
            channel = self._reserved.pop(finger)
        elif self._free:
            channel = self._free.pop(0)
        elif self._reserved:
            channel = self._reserved.pop(next(iter(self._reserved)))
        else:
            stolen = next(iter(self._sounding))
            channel = self._sounding.pop(stolen)
        self._sounding[finger] = channel
        return channel, stolen

    def end(self, finger: Finger) -> None:
        """A note has ended; its channel is the last to be used again."""
        channel = self._sounding.pop(finger, None)
        if channel is not None:
            self._free.append(channel)

    @property
    def hovering(self) -> list[Finger]:
        """Fingers with a reserved channel."""
        return list(self._reserved)
