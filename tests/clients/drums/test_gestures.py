"""Frames become hits, presses and shapes: once each, also if datagrams are lost."""

from __future__ import annotations

import json
import random
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

import halo_client
from halo_client import FileSource
from halo_client.strike import UNKNOWN_LEVEL
from halo_drums.kit import KIT, Settings, mirrored, pad_at
from halo_drums.midi import MidiOut, Notes
from halo_drums.player import Hit, Player, Press, Release, Shape
from halo_midi.errors import MidiError
from halo_protocol import Assembler, Frame, TouchFrame, encode_frame, event_to_json

LEFT, RIGHT = 1, 2
KICK = (0.88 * 300, 100.0)


def gestures_of(frames: list[TouchFrame], **settings: float) -> list[Any]:
    player = Player(settings=Settings(**settings))
    return [gesture for frame in frames for gesture in player.process(frame)]


def kinds(gestures: list[Any]) -> list[str]:
    return [type(gesture).__name__ for gesture in gestures]


@pytest.mark.parametrize(
    ("u", "v", "name"),
    [(0.1, 0.3, "high tom"), (0.3, 0.1, "low tom"), (0.68, 0.5, "snare"), (0.85, 0.5, "kick"),
     (0.2, 0.9, "closed hat"), (0.9, 0.7, "open hat"), (1.2, -0.1, "kick")],
)  # fmt: skip
def test_each_place_has_its_pad_on_either_hand(u: float, v: float, name: str) -> None:
    assert pad_at(KIT, u, v).name == name
    assert pad_at(mirrored(KIT), 1 - u, v).name == name


def test_the_kit_has_no_hole() -> None:
    for step in range(101):
        for other in range(101):
            pad_at(KIT, step / 100, other / 100)


def test_a_tap_is_one_hit_at_the_time_it_happened(wire: Any) -> None:
    tap = wire.frame(3, [wire.finger(at=KICK, pressure=0.5)], downs=(wire.down(at=KICK),))
    hit, release = gestures_of(
        [tap, wire.frame(4, [wire.finger(at=KICK, hover_mm=8.0)], ups=(wire.up(at=KICK),))]
    )
    assert isinstance(hit, Hit) and isinstance(release, Release)
    assert hit.pad.name == "kick"
    assert hit.time_us == tap.time_us - 12_000


def test_a_faster_strike_is_louder_and_an_unknown_one_is_medium(wire: Any) -> None:
    levels = []
    for number, strike in enumerate([0.0, 100.0, 250.0, 400.0, 900.0, -1.0]):
        (hit,) = gestures_of([wire.frame(number, downs=(wire.down(strike_mm_s=strike),))])
        levels.append(hit.level)
    assert levels[:4] == sorted(set(levels[:4]))
    assert levels[0] == 0.25 and levels[3] == levels[4] == 1.0
    assert levels[5] == UNKNOWN_LEVEL


def test_only_a_touch_that_stays_presses(wire: Any) -> None:
    frames = [wire.frame(0, [wire.finger(pressure=0.5)], downs=(wire.down(),))]
    frames += [wire.frame(n, [wire.finger(pressure=0.1 * n)]) for n in range(1, 10)]
    gestures = gestures_of(frames)
    assert kinds(gestures)[0] == "Hit"
    presses = [each for each in gestures if isinstance(each, Press)]
    assert [round(each.amount, 1) for each in presses] == [0.6, 0.7, 0.8, 0.9]


def test_the_hand_that_does_not_play_shapes_by_its_lowest_finger(wire: Any) -> None:
    other = [wire.finger(2, hand=LEFT, hover_mm=47.0), wire.finger(3, hand=LEFT, hover_mm=34.0)]
    frames = [
        wire.frame(0, [wire.finger(hover_mm=20.0), *other]),
        wire.frame(1, [wire.finger(pressure=0.5), *other], downs=(wire.down(),)),
        wire.frame(2, [wire.finger(hover_mm=3.0), *other]),
    ]
    gestures = gestures_of(frames, low_mm=8.0, high_mm=60.0)
    assert kinds(gestures) == ["Hit", "Shape", "Shape"], "no hand drums yet in the first frame"
    assert all(each.height == 0.5 for each in gestures[1:])


def test_a_hand_that_struck_a_moment_ago_does_not_shape(wire: Any) -> None:
    left = wire.finger(2, hand=LEFT, pressure=0.5)
    right = wire.finger(1, hand=RIGHT, pressure=0.5)
    frames = [
        wire.frame(0, [left], downs=(wire.down(2),)),
        wire.frame(3, [right, wire.finger(2, hand=LEFT, hover_mm=30.0)], downs=(wire.down(1),)),
        wire.frame(50, [wire.finger(2, hand=LEFT, hover_mm=30.0)]),
    ]
    assert kinds(gestures_of(frames)) == ["Hit", "Hit", "Shape"]


def test_of_unknown_hands_the_one_that_struck_is_the_drummer(wire: Any) -> None:
    frames = [
        wire.frame(0, [wire.finger(1, hand=0, pressure=0.4)], downs=(wire.down(1),)),
        wire.frame(1, [wire.finger(1, hand=0, hover_mm=9), wire.finger(2, hand=0, hover_mm=60)]),
    ]
    assert [each.height for each in gestures_of(frames) if isinstance(each, Shape)] == [1.0]


def rounds(wire: Any, hits: int) -> list[TouchFrame]:
    """A tap every 11 frames; the finger is down in 4 of them."""
    frames = []
    for number in range(hits * 11):
        touch, phase = divmod(number, 11)
        contacts = touch + (phase >= 4)
        pressed = 4 <= phase < 8
        pointer = wire.finger(
            contacts=contacts, pressure=0.5 if pressed else None, hover_mm=0 if pressed else 20.0
        )
        events: dict[str, Any] = {}
        if phase == 4:
            events["downs"] = (wire.down(contacts=contacts),)
        if phase == 8:
            events["ups"] = (wire.up(contacts=contacts),)
        frames.append(wire.frame(number, [pointer], **events))
    return frames


@pytest.mark.parametrize("seed", range(20))
def test_with_a_fifth_of_the_datagrams_lost_each_hit_sounds_once(wire: Any, seed: int) -> None:
    frames = rounds(wire, 40)
    lost = random.Random(seed)
    assembler = Assembler()
    received = []
    for number, frame in enumerate(frames):
        # As the service does: each event is repeated in the next two frames, with its age.
        repeated = [
            (event, (number - then.frame) * 1000 / 30)
            for then in frames[max(0, number - 2) : number + 1]
            for event in then.events
        ]
        aged = [replace(event, ago_ms=event.ago_ms + age) for event, age in repeated]
        header = Frame("desk", "s1", frame.frame, *divmod(frame.time_us, 1_000_000), 1)
        downs = [event for event in aged if hasattr(event, "strike_mm_s")]
        ups = [event for event in aged if not hasattr(event, "strike_mm_s")]
        for datagram in encode_frame("table", header, list(frame.pointers), downs, ups):
            if number == 0 or lost.random() >= 0.2:
                received += assembler.receive_data(datagram, number / 30)
    player = Player()
    arrived = [
        (event.time_us, gesture)
        for event in received
        if isinstance(event, TouchFrame)
        for gesture in player.process(event)
        if isinstance(gesture, Hit)
    ]
    assert [hit.key.contacts for _, hit in arrived] == list(range(1, 41))
    for number, (arrived_us, hit) in enumerate(arrived):
        struck_us = frames[11 * number + 4].time_us
        late = round((arrived_us - struck_us) / 33_333)
        assert 0 <= late <= 7, "late by the number of lost frames"
        if hit.level != UNKNOWN_LEVEL:
            assert hit.time_us == pytest.approx(struck_us - 12_000, abs=1_000)


def test_a_stream_from_a_file_sounds_like_a_live_one(wire: Any, tmp_path: Path) -> None:
    path = tmp_path / "take.jsonl"
    frames = rounds(wire, 3)
    path.write_text("".join(json.dumps(event_to_json(frame)) + "\n" for frame in frames))
    from_file = gestures_of(list(halo_client.frames(FileSource(path, paced=False))))
    hits = [each for each in from_file if isinstance(each, Hit)]
    assert len(hits) == 3
    assert [hit.level for hit in hits] == pytest.approx([hits[0].level] * 3)


def test_midi_messages_are_what_a_sampler_understands(wire: Any) -> None:
    notes = Notes()
    hit, release = gestures_of(
        [wire.frame(0, downs=(wire.down(at=KICK, strike_mm_s=500.0),), ups=(wire.up(at=KICK),))]
    )
    messages = [
        *notes.messages(hit),
        *notes.messages(Press(0, hit.key, 0.5)),
        *notes.messages(Shape(0, 1.0)),
        *notes.messages(release),
        *notes.messages(release),
    ]
    assert [message.bytes() for message in messages] == [
        [0x99, 36, 127], [0xA9, 36, 64], [0xB9, 74, 127], [0x89, 36, 64],
    ]  # fmt: skip


def test_a_missing_midi_port_gives_one_sentence() -> None:
    with pytest.raises(MidiError) as refused:
        MidiOut("no such sampler")
    assert "MIDI" in str(refused.value)
    assert "\n" not in str(refused.value)


class Port:
    """A MIDI port that may die."""

    def __init__(self) -> None:
        self.sent: list[list[int]] = []
        self.dead = False

    def send(self, message: Any) -> None:
        if self.dead:
            raise OSError("the port was closed")
        self.sent.append(message.bytes())

    def reset(self) -> None:
        pass

    def close(self) -> None:
        pass


class Samplers:
    """MIDI ports that come and go."""

    def __init__(self) -> None:
        self.names = ["Midi Through 14:0", "FLUID Synth (321) 128:0"]
        self.opened: dict[str, Port] = {}

    def get_output_names(self) -> list[str]:
        return list(self.names)

    def open_output(self, name: str) -> Port:
        self.opened[name] = Port()
        return self.opened[name]


@pytest.mark.parametrize("reported", [True, False], ids=["send fails", "nothing reports it"])
def test_a_midi_port_that_dies_comes_back(
    wire: Any, caplog: pytest.LogCaptureFixture, reported: bool
) -> None:
    ports = Samplers()
    (hit,) = gestures_of([wire.frame(0, downs=(wire.down(at=KICK, strike_mm_s=500.0),))])
    note = [[0x99, 36, 127]]
    with MidiOut("fluid", ports, look_s=0.01) as midi:
        midi.send(hit)
        first = ports.opened["FLUID Synth (321) 128:0"]
        assert first.sent == note
        ports.names = ports.names[:1]
        first.dead = reported
        midi.send(hit)  # no error, whatever happens
        wait_for(lambda: "is lost" in caplog.text)
        midi.send(hit)
        ports.names = [*ports.names, "FLUID Synth (400) 129:0"]
        wait_for(lambda: "is back" in caplog.text)
        midi.send(hit)
        assert ports.opened["FLUID Synth (400) 129:0"].sent == note
    assert first.sent[0] == note[0]


def wait_for(condition: Callable[[], bool]) -> None:
    until = time.monotonic() + 10.0
    while not condition():
        assert time.monotonic() < until
        time.sleep(0.005)
