"""A virtual drummer, a painter and a press as MIDI: MPE's rules, onsets, and pressure.

Two parsers that others wrote read the files: mido (PyPI) and JZZ (npm). `npm install` in
tests/clients/midi/reader brings the second.
"""

from __future__ import annotations

import json
import os
import subprocess
import wave
from collections.abc import Callable
from pathlib import Path
from typing import Any

import mido
import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.stats import spearmanr

import halo_client
from halo_client import FileSource
from halo_midi.layouts import LAYOUTS, board
from halo_midi.player import Player
from halo_midi.render import RATE, TEMPO_US, TICKS, messages, midi_file, write
from halo_midi.settings import Settings, Slide
from halo_protocol import TouchFrame
from tests.clients.midi.mpe import NOTE_ON, PRESSURE, Receiver
from tests.clients.recorded.record import truth_of
from tests.clients.recordings import recorded, truth
from tests.clients.streams import Session
from tests.kind_sensor import KIND_URL

READER = Path(__file__).parent / "reader"
TICK_S = TEMPO_US / TICKS / 1e6
Events = list[tuple[float, list[int]]]
"""Seconds, and the bytes of a message."""


def play(frames: tuple[TouchFrame, ...], layout: str = "grid", **settings: Any) -> mido.MidiFile:
    return midi_file(messages(frames, Player(board(layout), Settings(**settings))))


def by_mido(file: mido.MidiFile) -> Events:
    at_s, events = 0.0, []
    for message in file:
        at_s += message.time
        if not message.is_meta:
            events.append((at_s, message.bytes()))
    return events


def check(events: Events) -> Receiver:
    receiver = Receiver()
    for _, message in events:
        receiver.read(message)
    return receiver


@pytest.mark.parametrize("stream", ["drumming", "painting"])
@pytest.mark.parametrize("layout", LAYOUTS)
def test_each_layout_obeys_the_rules_of_mpe(stream: str, layout: str) -> None:
    for settings in ({}, {"members": 2, "bend_semitones": 24}):
        receiver = check(by_mido(play(recorded(stream), layout, **settings)))
        assert receiver.end() == []
        assert receiver.members == settings.get("members", 15)
        assert set(receiver.ranges.values()) == {settings.get("bend_semitones", 48)}
        assert len(receiver.notes) > 0


def test_the_check_finds_what_breaks_the_rules() -> None:
    events = [bytes_ for _, bytes_ in by_mido(play(recorded("drumming")))]
    first = next(n for n, each in enumerate(events) if each[0] & 0xF0 == NOTE_ON)
    note = events[first]
    broken = {
        "no MPE Configuration Message": events[3:],
        "a note on channel 0": [*events[:first], [NOTE_ON, *note[1:]], *events[first:]],
        "two notes at once on channel": [*events[: first + 1], note, *events[first + 1 :]],
        "polyphonic pressure": [*events, [0xA1, 60, 3]],
        "controller 7 on a member": [*events, [0xB1, 7, 3]],
        "channel mode 123 on a member": [*events, [0xB1, 123, 0]],
        "starts without bend": [each for each in events if each[0] & 0xF0 != 0xE0],
        "notes sound at the end": events[: first + 1],
        "no bend range": [each for each in events if each[:2] != [0xB3, 6]],
    }
    for rule, stream in broken.items():
        assert any(rule in each for each in check([(0.0, each) for each in stream]).end()), rule


@pytest.mark.skipif(
    not (READER / "node_modules").is_dir() and "HALO_CI" not in os.environ,
    reason="jzz is not installed: npm install in tests/clients/midi/reader",
)
@pytest.mark.parametrize("stream", ["drumming", "painting"])
def test_a_parser_of_another_language_reads_the_same(
    stream: str, external_program: Callable[[str], str], tmp_path: Path
) -> None:
    file = play(recorded(stream))
    path = tmp_path / "take.mid"
    file.save(path)
    script = [external_program("node"), str(READER / "read.js"), str(path)]
    printed = subprocess.run(script, capture_output=True, text=True, check=True).stdout
    *lines, end = [json.loads(line) for line in printed.splitlines()]
    assert end == {"warnings": [], "ppqn": TICKS}
    theirs = [(line["tick"] * TICK_S, line["bytes"]) for line in lines]
    assert [each for _, each in theirs] == [each for _, each in by_mido(file)]
    assert [at for at, _ in theirs] == pytest.approx([at for at, _ in by_mido(file)])
    assert check(theirs).end() == []
    notes = [line for line in lines if line["bytes"][0] & 0xF0 == NOTE_ON]
    assert {line["master"] for line in notes} == {0}, "JZZ has each note in the zone of channel 1"


def notes_s(file: mido.MidiFile) -> list[float]:
    return [at for at, each in by_mido(file) if each[0] & 0xF0 == NOTE_ON]


def downs_s(frames: tuple[TouchFrame, ...]) -> list[float]:
    start_us = frames[0].time_us
    return sorted(
        (frame.time_us - start_us) / 1e6 - down.ago_ms / 1e3
        for frame in frames
        for down in frame.downs
    )


@pytest.mark.parametrize("stream", ["drumming", "painting"])
def test_each_touch_is_one_note_at_its_time(stream: str) -> None:
    frames = recorded(stream)
    notes, downs = notes_s(play(frames)), downs_s(frames)
    assert len(notes) == len(downs) > 0
    errors_ms = [1e3 * abs(note - down) for note, down in zip(notes, downs, strict=True)]
    print(f"{stream}: {len(notes)} notes, off by at most {max(errors_ms):.2f} ms")
    assert max(errors_ms) < 5.0
    true_s = [(at - frames[0].time_us) / 1e6 for at in truth(stream)["downs_us"]]
    late_ms = sorted(1e3 * min((note - at for note in notes), key=abs) for at in true_s)
    print("from the true touches:", np.round(late_ms, 1), "ms")


def test_a_note_after_lost_frames_keeps_its_time_and_the_order(wire: Any) -> None:
    """The touch is older than what was sent for the finger that hovered meanwhile."""
    frames = (
        wire.frame(0, [wire.finger(hover_mm=20.0)]),
        wire.frame(1, [wire.finger(at=(150.0, 90.0), hover_mm=9.0)]),
        wire.frame(4, [wire.finger(pressure=0.5)], downs=(wire.down(ago_ms=120.0),)),
    )
    events = by_mido(play(frames))
    assert check(events).end() == []
    (note,) = [at for at, each in events if each[0] & 0xF0 == NOTE_ON]
    assert note == pytest.approx(4 * 0.033333 - 0.120, abs=0.001)


def onsets_s(sound: NDArray[np.float64]) -> list[float]:
    """Times at which the level of a woodblock jumps to four times that of the 30 ms before."""
    step = RATE // 1000
    level = np.abs(sound[: len(sound) // step * step]).reshape(-1, step).max(axis=1)
    found: list[float] = []
    for at in range(30, len(level)):
        jump = level[at] > 4.0 * level[at - 30 : at].max() and level[at] > 0.01
        if jump and (not found or at / 1000 - found[-1] > 0.03):
            found.append(at / 1000)
    return found


def test_fluidsynth_sounds_each_note_at_its_time(
    external_program: Callable[[str], str], tmp_path: Path
) -> None:
    external_program("fluidsynth")
    frames = recorded("drumming")
    path = tmp_path / "take.wav"
    player = Player(board("drums"), Settings(slide=Slide.OFF, hover_control=0))
    write(path, messages(frames, player), 115, None)
    with wave.open(str(path)) as file:
        assert (file.getframerate(), file.getnchannels()) == (RATE, 2)
        data = np.frombuffer(file.readframes(file.getnframes()), "<i2")
    sound = data.reshape(-1, 2).mean(axis=1) / 32_768
    onsets, downs = onsets_s(sound), downs_s(frames)
    errors_ms = [1e3 * min(abs(onset - down) for onset in onsets) for down in downs]
    print(f"{len(downs)} downs, {len(onsets)} onsets, off by at most {max(errors_ms):.1f} ms")
    assert len(onsets) == len(downs)
    assert max(errors_ms) < 5.0


def pressures(frames: tuple[TouchFrame, ...]) -> dict[int, tuple[int, float]]:
    """Frame time to the pressure of the note's channel then, and to the finger's pressure,
    up to the one of value 127."""
    player = Player(board("grid"))
    found, value = {}, 0
    for frame in frames:
        for sent in player.process(frame):
            data = sent.message.bytes()
            value = data[1] if data[0] & 0xF0 == PRESSURE else value
        touching = [each.pressure for each in frame.pointers if each.touching]
        if len(touching) == 1:
            found[frame.time_us] = (value, min(touching[0], Settings().full_pressure))
    return found


def rank(pairs: list[tuple[float, float]]) -> float:
    return float(spearmanr(*zip(*pairs, strict=True)).statistic)


def to_force(frames: tuple[TouchFrame, ...], forces_g: dict[Any, float]) -> float:
    forces = {int(at): force for at, force in forces_g.items()}
    pairs = [(value, forces[at]) for at, (value, _) in pressures(frames).items() if at in forces]
    return rank(pairs)


@pytest.mark.parametrize("stream", ["drumming", "painting"])
def test_pressure_keeps_the_order_of_the_service_s_pressure(stream: str) -> None:
    """What is left to the true force is the sensing's: measured below, and printed here."""
    figure = rank(list(pressures(recorded(stream)).values()))
    force = to_force(recorded(stream), truth(stream)["forces_g"])
    print(f"{stream}: rank correlation {figure:.3f}; with the true force {force:.3f}")
    assert figure > 0.99


@pytest.mark.long
def test_pressure_follows_the_true_force(sensed: Callable[[str, float], Session]) -> None:
    """Five held forces, twice each: the scenario `pressure` as a whole."""
    session = sensed(f"sim:pressure?seed=3&{KIND_URL}", 32.0)
    frames = tuple(halo_client.frames(FileSource(session.stream, paced=False)))
    figure = to_force(frames, truth_of(session)["forces_g"])
    print(f"held forces: rank correlation {figure:.3f} with the true force")
    assert figure >= 0.95
    assert check(by_mido(play(frames))).end() == []
