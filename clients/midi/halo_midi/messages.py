"""The MIDI messages of MPE.

Rule: pure. Values are 0 to 1, pitches are semitones; the bytes are computed here alone. A value
that a channel already has is not sent again.
"""

from __future__ import annotations

from collections.abc import Iterable

import mido

from halo_midi.zone import MASTER

SLIDE = 74
"""Controller of MPE's third dimension."""
ALL_NOTES_OFF = 123
RPN_MSB, RPN_LSB, DATA_MSB, DATA_LSB = 101, 100, 6, 38
BEND_RANGE, MPE_CONFIGURATION, NO_RPN = 0, 6, 127
CENTRE_RELEASE = 64
"""Release velocity if the speed of the lift is not measured."""


def configuration(members: int, bend_semitones: int) -> list[mido.Message]:
    """Make a zone: the MPE Configuration Message, then the bend range of each member.

    In this order: the first message sets every range back to 48 semitones. The range is sent on
    each member, for synthesisers without MPE.
    """
    messages = [
        *_rpn(MASTER, MPE_CONFIGURATION),
        control(MASTER, DATA_MSB, members),
        *_rpn(MASTER, NO_RPN),
    ]
    for channel in range(1, members + 1):
        messages += _rpn(channel, BEND_RANGE)
        messages += [control(channel, DATA_MSB, bend_semitones), control(channel, DATA_LSB, 0)]
        messages += _rpn(channel, NO_RPN)
    return messages


def control(channel: int, controller: int, value: int) -> mido.Message:
    """A control change."""
    return mido.Message("control_change", channel=channel, control=controller, value=value)


def note_on(channel: int, note: int, level: float) -> mido.Message:
    """A note starts; a velocity of 0 would end it."""
    return mido.Message("note_on", channel=channel, note=note, velocity=max(1, seven(level)))


def note_off(channel: int, note: int, level: float | None = None) -> mido.Message:
    """A note ends; `level` None: the speed of the lift is not measured."""
    velocity = CENTRE_RELEASE if level is None else seven(level)
    return mido.Message("note_off", channel=channel, note=note, velocity=velocity)


def seven(value: float) -> int:
    """Convert 0..1 to 0..127."""
    return round(127 * min(max(value, 0.0), 1.0))


class Values:
    """The values that the channels have; each method returns the message that changes one."""

    def __init__(self, bend_semitones: int) -> None:
        self._bend_semitones = bend_semitones
        self._sent: dict[tuple[int, str, int], list[int]] = {}

    def bend(self, channel: int, semitones: float) -> list[mido.Message]:
        """Pitch bend, clipped to its range."""
        value = round(8192 * semitones / self._bend_semitones)
        value = min(max(value, -8192), 8191)
        return self._changed(mido.Message("pitchwheel", channel=channel, pitch=value))

    def pressure(self, channel: int, level: float) -> list[mido.Message]:
        """Channel pressure."""
        return self._changed(mido.Message("aftertouch", channel=channel, value=seven(level)))

    def control(self, channel: int, controller: int, level: float) -> list[mido.Message]:
        """A control change."""
        return self._changed(control(channel, controller, seven(level)))

    def _changed(self, message: mido.Message) -> list[mido.Message]:
        name = (message.channel, message.type, getattr(message, "control", -1))
        if self._sent.get(name) == message.bytes():
            return []
        self._sent[name] = message.bytes()
        return [message]


def _rpn(channel: int, number: int) -> Iterable[mido.Message]:
    """Select a registered parameter; 127 selects none, so that later data changes nothing."""
    msb = NO_RPN if number == NO_RPN else 0
    return control(channel, RPN_MSB, msb), control(channel, RPN_LSB, number)
