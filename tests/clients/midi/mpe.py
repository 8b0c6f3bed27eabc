"""The rules of MIDI Polyphonic Expression 1.0 for a sender with a lower zone, as a check.

It knows bytes and nothing of `halo_midi`. Channels are counted from 0, as in the bytes.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

NOTE_OFF, NOTE_ON, POLY, CONTROL, PROGRAM, PRESSURE, BEND = range(0x80, 0xF0, 0x10)
MASTER, SLIDE, DATA, DATA_LSB, RPN_LSB, RPN_MSB = 0, 74, 6, 38, 100, 101
CHANNEL_MODE = range(120, 128)
WIDEST_BEND = 96


@dataclass
class Receiver:
    """What a synthesiser knows; `broken` lists each rule that a message breaks."""

    members: int = 0
    """Of the zone; 0 before the MPE Configuration Message."""
    ranges: dict[int, int] = field(default_factory=dict)
    """Channel to pitch bend range, semitones."""
    broken: list[str] = field(default_factory=list)
    notes: list[tuple[int, int, int]] = field(default_factory=list)
    """Channel, note and velocity of each note, in their order."""
    _rpn: dict[int, list[int]] = field(default_factory=dict)
    _sounding: dict[int, int] = field(default_factory=dict)
    _values: dict[int, set[int]] = field(default_factory=dict)

    def read(self, message: Sequence[int]) -> None:
        """Process a message."""
        kind, channel = message[0] & 0xF0, message[0] & 0x0F
        if kind == CONTROL:
            self._control(channel, message[1], message[2])
        elif kind in (NOTE_ON, NOTE_OFF):
            self._note(kind, channel, message[1], message[2])
        elif kind in (BEND, PRESSURE):
            self._values.setdefault(channel, set()).add(kind)
            self._require(self.members > 0, "a value comes before the zone")
            self._require(channel <= self.members, f"a value on channel {channel} outside the zone")
        else:
            self._require(kind != POLY, "polyphonic pressure on a member channel")
            self._require(kind != PROGRAM or channel == MASTER, "a program on a member channel")

    def end(self) -> list[str]:
        """Return the broken rules of the whole stream."""
        self._require(self.members > 0, "no MPE Configuration Message")
        self._require(not self._sounding, f"notes sound at the end: {self._sounding}")
        missing = set(range(1, self.members + 1)) - self.ranges.keys()
        self._require(not missing, f"no bend range on channels {missing}")
        return self.broken

    def _note(self, kind: int, channel: int, note: int, velocity: int) -> None:
        self._require(1 <= channel <= self.members, f"a note on channel {channel}")
        if kind == NOTE_OFF or velocity == 0:
            self._require(kind == NOTE_OFF, "a note ends without a release velocity")
            self._require(self._sounding.get(channel) == note, f"note {note} ends without a start")
            self._sounding.pop(channel, None)
            return
        self._require(channel not in self._sounding, f"two notes at once on channel {channel}")
        self._require(
            {BEND, PRESSURE, SLIDE} <= self._values.get(channel, set()),
            f"note {note} starts without bend, slide or pressure on channel {channel}",
        )
        self._sounding[channel] = note
        self.notes.append((channel, note, velocity))

    def _control(self, channel: int, control: int, value: int) -> None:
        chosen = self._rpn.setdefault(channel, [127, 127])
        if control in (RPN_MSB, RPN_LSB):
            chosen[control == RPN_LSB] = value
        elif control == DATA:
            self._data(channel, chosen, value)
        elif control == SLIDE:
            self._values.setdefault(channel, set()).add(SLIDE)
            self._require(self.members > 0, "a value comes before the zone")
        elif control in CHANNEL_MODE:
            self._require(channel == MASTER, f"channel mode {control} on a member channel")
        elif control != DATA_LSB:
            self._require(channel == MASTER, f"controller {control} on a member channel")

    def _data(self, channel: int, chosen: list[int], value: int) -> None:
        if chosen == [0, 6]:
            self._require(channel == MASTER, f"a zone on channel {channel}")
            self._require(1 <= value <= 15, f"a zone of {value} channels")
            self._require(not self._sounding, "the zone changes while notes sound")
            # A receiver sets every range back and forgets the values of the channels.
            self.members, self.ranges, self._values = value, {}, {}
        elif chosen == [0, 0]:
            self._require(1 <= channel <= self.members, "a bend range before or outside its zone")
            self._require(value <= WIDEST_BEND, f"a bend range of {value} semitones")
            self.ranges[channel] = value
        else:
            self._require(False, f"data for the parameter {chosen}")

    def _require(self, holds: bool, rule: str) -> None:
        if not holds:
            self.broken.append(rule)
