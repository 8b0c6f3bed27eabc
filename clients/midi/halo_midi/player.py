"""From frames to MPE messages.

Rule: pure. Each message has its time on the frames' clock: a note starts at the time of the
touch (frame time minus `ago_ms`), everything else at the frame's time.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import mido

from halo_client import Began, Ended, Moved, TouchKey, touches
from halo_client.strike import loudness
from halo_midi.layouts import Board, Key
from halo_midi.messages import (
    ALL_NOTES_OFF,
    SLIDE,
    Values,
    configuration,
    control,
    note_off,
    note_on,
)
from halo_midi.settings import Settings, Slide
from halo_midi.zone import MASTER, Zone
from halo_protocol import Finger, Pointer, TouchFrame

RESET_CONTROLLERS = 121
SOFTEST = 0.1
"""Velocity of the softest strike, relative to the loudest."""
AIR_LEVEL = 0.7
"""Velocity of a note in the air, which has no strike."""
AIR_MARGIN = 1.15
"""A note in the air ends this much above the reach, so that noise does not repeat it."""
LIFT_MM_S = 300.0
"""Lift speed of release velocity 127."""
SHORTEST_LIFT_MS = 5.0
"""A shorter way from the touch to its frame gives no speed."""

PAUSE_US = 10_000_000
"""Empty table after which the zone is configured again."""

FingerKey = tuple[str, str, str, int]
"""Node, surface, session, finger id."""


@dataclass(frozen=True, slots=True)
class Sent:
    """A message and its time."""

    time_us: int
    message: mido.Message


@dataclass(slots=True)
class _Voice:
    """A note that sounds."""

    channel: int
    note: int
    pitch: float
    """At the place where it started."""
    u: float
    """Of this place."""
    key: Key
    """Of this place."""


class Player:
    """Remembers the notes and the channels of the fingers."""

    def __init__(
        self, board: Board, settings: Settings | None = None, repeats: bool = False
    ) -> None:
        """`repeats`: configure the zone again after a pause, for synthesisers that start later."""
        self._board = board
        self._settings = settings or Settings()
        self._air = board.layout.in_air
        self._repeats = repeats
        self._empty_since_us: int | None = None
        self._reset()

    def opening(self) -> list[mido.Message]:
        """Return what a synthesiser needs first. Notes of an earlier connection are forgotten."""
        self._reset()
        return configuration(self._settings.members, self._settings.bend_semitones)

    def closing(self) -> list[mido.Message]:
        """Return what ends all notes."""
        ended = [note_off(voice.channel, voice.note) for voice in self._voices.values()]
        self._reset()
        last = (ALL_NOTES_OFF, RESET_CONTROLLERS)
        return [*ended, *(control(MASTER, each, 0) for each in last)]

    def process(self, frame: TouchFrame) -> list[Sent]:
        """Return the messages of a frame, in their order."""
        sent: list[Sent] = []
        if self._repeats and self._returns(frame):
            sent += _at(frame.time_us, self.opening())
        if self._air:
            self._process_air(frame, sent)
        else:
            self._process_touches(frame, sent)
            self._hover(frame, sent)
        return sent

    def _reset(self) -> None:
        self._zone: Zone[FingerKey] = Zone(self._settings.members)
        self._values = Values(self._settings.bend_semitones)
        self._voices: dict[FingerKey, _Voice] = {}

    def _returns(self, frame: TouchFrame) -> bool:
        """Whether a hand comes after a pause: no note sounds or rings then."""
        if not frame.pointers:
            if self._empty_since_us is None:
                self._empty_since_us = frame.time_us
            return False
        since_us, self._empty_since_us = self._empty_since_us, None
        return since_us is not None and frame.time_us - since_us > PAUSE_US

    def _process_touches(self, frame: TouchFrame, sent: list[Sent]) -> None:
        living = {pointer.id: pointer for pointer in frame.pointers}
        for touch in touches(frame):
            finger = _finger(touch.key)
            if isinstance(touch, Began):
                at = (touch.time_us, touch.down.u, touch.down.v)
                pressure = 0.0 if touch.pointer is None else self._press(touch.pointer)
                level = self._level(touch.down.strike_mm_s)
                self._start(finger, at, level, pressure, sent)
            elif isinstance(touch, Moved):
                self._move(finger, touch.pointer, frame, sent)
            else:
                self._end(finger, touch.time_us, _lift(touch, living), sent)
        touching = {_key(frame, each) for each in frame.pointers if each.touching}
        for finger in [
            each for each in self._voices if each not in touching
        ]:  # lost without an `up`
            self._end(finger, frame.time_us, None, sent)

    def _process_air(self, frame: TouchFrame, sent: list[Sent]) -> None:
        reach_mm = self._settings.reach_mm
        near = {
            _key(frame, each): each
            for each in frame.pointers
            if each.finger == Finger.INDEX
            and each.hover_mm <= reach_mm * (AIR_MARGIN if _key(frame, each) in self._voices else 1)
        }
        for finger in [each for each in self._voices if each not in near]:
            self._end(finger, frame.time_us, None, sent)
        for finger, pointer in near.items():
            if finger not in self._voices:
                at = (frame.time_us, pointer.u, pointer.v)
                self._start(finger, at, AIR_LEVEL, self._press(pointer), sent)
            self._move(finger, pointer, frame, sent)

    def _start(
        self,
        finger: FingerKey,
        at: tuple[int, float, float],
        level: float,
        pressure: float,
        sent: list[Sent],
    ) -> None:
        """Send the values of a note, then the note: a synthesiser starts it with these values.

        `at`: time, u and v.
        """
        time_us, u, v = at
        self._end(finger, time_us, None, sent)
        channel, stolen = self._zone.start(finger)
        if stolen is not None and (lost := self._voices.pop(stolen, None)) is not None:
            sent.append(Sent(time_us, note_off(lost.channel, lost.note)))
        key, pitch = self._board.key(u, v), self._board.pitch(u, v)
        note = min(max(round(pitch), 0), 127)
        self._voices[finger] = _Voice(channel, note, pitch, u, key)
        before = self._values.bend(channel, pitch - note)
        if self._settings.slide is Slide.Y:
            before += self._values.control(channel, SLIDE, key.slide(v))
        before += self._values.pressure(channel, pressure)
        sent += _at(time_us, [*before, note_on(channel, note, level)])

    def _move(
        self, finger: FingerKey, pointer: Pointer, frame: TouchFrame, sent: list[Sent]
    ) -> None:
        voice = self._voices.get(finger)
        if voice is None:  # it touched before this program started, or lost its channel
            return
        semitones = self._board.layout.semitones * (pointer.u - voice.u)
        messages = self._values.bend(voice.channel, voice.pitch + semitones - voice.note)
        if self._settings.slide is Slide.Y:
            messages += self._values.control(voice.channel, SLIDE, voice.key.slide(pointer.v))
        elif self._settings.slide is Slide.HOVER and (low_mm := _lowest_mm(frame)) is not None:
            messages += self._values.control(voice.channel, SLIDE, self._height(low_mm))
        messages += self._values.pressure(voice.channel, self._press(pointer))
        sent += _at(frame.time_us, messages)

    def _end(self, finger: FingerKey, time_us: int, level: float | None, sent: list[Sent]) -> None:
        voice = self._voices.pop(finger, None)
        if voice is not None:
            self._zone.end(finger)
            sent.append(Sent(time_us, note_off(voice.channel, voice.note, level)))

    def _hover(self, frame: TouchFrame, sent: list[Sent]) -> None:
        """Values before the note: controller 74 on the finger's channel, height on the master."""
        near = {
            _key(frame, each): each
            for each in frame.pointers
            if not each.touching and each.hover_mm <= self._settings.reach_mm
        }
        for finger in self._zone.hovering:
            if finger not in near:
                self._zone.cancel(finger)
        messages: list[mido.Message] = []
        for finger, pointer in near.items():
            channel = self._zone.reserve(finger)
            if channel is not None:
                messages += self._slide_before(channel, pointer)
        if self._settings.hover_control:
            low_mm = min((each.hover_mm for each in near.values()), default=None)
            close = 0.0 if low_mm is None else 1.0 - self._height(low_mm)
            messages += self._values.control(MASTER, self._settings.hover_control, close)
        sent += _at(frame.time_us, messages)

    def _slide_before(self, channel: int, pointer: Pointer) -> list[mido.Message]:
        if self._settings.slide is Slide.OFF:
            return []
        value = self._height(pointer.hover_mm)
        if self._settings.slide is Slide.Y:
            value = self._board.key(pointer.u, pointer.v).slide(pointer.v)
        return self._values.control(channel, SLIDE, value)

    def _level(self, strike_mm_s: float) -> float:
        settings = self._settings
        return loudness(strike_mm_s, SOFTEST, settings.loud_mm_s, settings.soft_mm_s)

    def _press(self, pointer: Pointer) -> float:
        if self._air:
            return 1.0 - self._height(pointer.hover_mm)
        return pointer.pressure / self._settings.full_pressure

    def _height(self, hover_mm: float) -> float:
        """0 at the surface, 1 at the end of the reach."""
        return min(max(hover_mm / self._settings.reach_mm, 0.0), 1.0)


def _lowest_mm(frame: TouchFrame) -> float | None:
    return min((each.hover_mm for each in frame.pointers if not each.touching), default=None)


def _lift(touch: Ended, living: dict[int, Pointer]) -> float | None:
    """Release velocity: the height of the finger now, over the time since its lift."""
    pointer = living.get(touch.up.id)
    if pointer is None or pointer.touching or touch.up.ago_ms < SHORTEST_LIFT_MS:
        return None
    return pointer.hover_mm / (touch.up.ago_ms / 1e3) / LIFT_MM_S


def _at(time_us: int, messages: Iterable[mido.Message]) -> list[Sent]:
    return [Sent(time_us, message) for message in messages]


def _key(frame: TouchFrame, pointer: Pointer) -> FingerKey:
    return (frame.node, frame.surface, frame.session, pointer.id)


def _finger(key: TouchKey) -> FingerKey:
    return (key.node, key.surface, key.session, key.id)
