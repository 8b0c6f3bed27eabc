"""Frames become notes: values first, then the note; hover before it; silence at every end."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import mido
import pytest

from halo_client.strike import UNKNOWN_LEVEL
from halo_midi.layouts import board
from halo_midi.messages import seven
from halo_midi.player import Player, Sent
from halo_midi.settings import Settings, Slide
from halo_protocol import Pointer, TouchFrame
from tests.clients.midi.mpe import Receiver

C, C_SHARP = (15.0, 190.0), (55.0, 190.0)
"""Places of the grid's first two pads, on a surface of 300 x 200 mm."""


def play(frames: list[TouchFrame], layout: str = "grid", **settings: Any) -> list[Sent]:
    player = Player(board(layout), Settings(**settings))
    return [sent for frame in frames for sent in player.process(frame)]


def texts(sent: list[Sent]) -> list[str]:
    """Short forms such as 'on 48', 'bend 0', 'cc74 63'."""
    return [text(each.message) for each in sent]


def text(message: mido.Message) -> str:
    kind, value = message.type, message.bytes()[-1]
    if kind in ("note_on", "note_off"):
        return f"{kind[5:]} {message.note}"
    if kind == "pitchwheel":
        return f"bend {message.pitch}"
    return f"cc{message.control} {value}" if kind == "control_change" else f"press {value}"


def tap(wire: Any, at: tuple[float, float] = C, **down: Any) -> TouchFrame:
    return wire.frame(3, [wire.finger(at=at, pressure=0.75)], downs=(wire.down(at=at, **down),))


def test_a_strike_is_bend_slide_pressure_and_then_the_note_at_its_time(wire: Any) -> None:
    frame = tap(wire)
    sent = play([frame])
    assert texts(sent)[:4] == ["bend 0", "cc74 32", "press 48", "on 48"]
    assert {each.time_us for each in sent[:4]} == {frame.time_us - 12_000}
    assert {each.message.channel for each in sent[:4]} == {1}


@pytest.mark.parametrize(
    ("strike", "velocity"), [(0.0, 13), (200.0, 88), (400.0, 127), (900.0, 127), (-1.0, 76)]
)
def test_velocity_is_the_speed_of_the_strike(wire: Any, strike: float, velocity: int) -> None:
    (on,) = [
        each.message for each in play([tap(wire, strike_mm_s=strike)]) if "on" in text(each.message)
    ]
    assert on.velocity == velocity
    assert seven(UNKNOWN_LEVEL) == 76


def test_a_curve_of_one_s_own_moves_both_ends(wire: Any) -> None:
    velocities = [
        next(
            each.message.velocity
            for each in play([tap(wire, strike_mm_s=speed)], soft_mm_s=100.0, loud_mm_s=200.0)
            if each.message.type == "note_on"
        )
        for speed in (90.0, 100.0, 150.0, 200.0)
    ]
    assert velocities == [13, 13, 88, 127]


def test_a_finger_that_moves_bends_slides_and_presses(wire: Any) -> None:
    moved = (C[0] + 300 / 8, C[1] - 20)
    frames = [tap(wire), wire.frame(4, [wire.finger(at=moved, pressure=1.5)])]
    sent = [each for each in play(frames) if each.time_us == frames[1].time_us]
    semitone = round(8192 / 48)
    assert texts(sent)[:3] == [f"bend {semitone}", "cc74 95", "press 95"]


def test_a_value_that_stays_is_not_sent_again(wire: Any) -> None:
    still = [tap(wire)] + [wire.frame(n, [wire.finger(at=C, pressure=0.75)]) for n in range(4, 9)]
    assert len(play(still)) == len(play(still[:1]))


def test_any_pitch_of_the_ribbon_is_the_nearest_note_and_a_bend(wire: Any) -> None:
    at = (300 * 0.4 / 36, 100.0)  # 0.4 semitones above the lowest note
    sent = play([tap(wire, at)], "ribbon", bend_semitones=2)
    assert texts(sent)[0] == f"bend {round(8192 * 0.4 / 2)}"
    assert "on 48" in texts(sent)


def test_a_lift_ends_the_note_at_its_time_with_its_speed(wire: Any) -> None:
    lifted = wire.frame(
        4, [wire.finger(at=C, hover_mm=6.0)], ups=(replace(wire.up(at=C), ago_ms=40.0),)
    )
    off = next(each for each in play([tap(wire), lifted]) if each.message.type == "note_off")
    assert off.time_us == lifted.time_us - 40_000
    assert off.message.velocity == seven(6.0 / 0.040 / 300.0)


def test_a_finger_that_is_lost_ends_its_note(wire: Any) -> None:
    sent = play([tap(wire), wire.frame(4)])
    assert texts(sent)[-1] == "off 48" or "off 48" in texts(sent)
    off = next(each.message for each in sent if each.message.type == "note_off")
    assert off.velocity == 64, "the speed of its lift is not measured"


def test_the_same_finger_rings_on_one_channel_and_strikes_on_another(wire: Any) -> None:
    frames = [
        tap(wire),
        wire.frame(4, [wire.finger(at=C, hover_mm=6.0)], ups=(wire.up(at=C),)),
        wire.frame(
            5, [wire.finger(at=C, pressure=0.5, contacts=2)], downs=(wire.down(at=C, contacts=2),)
        ),
    ]
    channels = [each.message.channel for each in play(frames) if each.message.type == "note_on"]
    assert channels == [1, 2]


def test_a_stolen_note_ends_before_the_new_one_starts(wire: Any) -> None:
    frames = [
        wire.frame(
            n,
            [wire.finger(id=k, at=C, pressure=0.5) for k in range(n + 1)],
            downs=(wire.down(id=n, at=C),),
        )
        for n in range(3)
    ]
    notes = [
        each for each in texts(play(frames, members=2, hover_control=0)) if each[:2] in ("on", "of")
    ]
    assert notes == ["on 48", "on 48", "off 48", "on 48"]


def test_hover_is_the_modulation_wheel_of_the_master_and_ends_with_the_note(wire: Any) -> None:
    frames = [
        wire.frame(0, [wire.finger(at=C, hover_mm=60.0)]),
        wire.frame(1, [wire.finger(at=C, hover_mm=25.0)]),
        wire.frame(2, [wire.finger(at=C, hover_mm=25.0), wire.finger(id=2, hover_mm=5.0)]),
        tap(wire),
    ]
    wheel = [each.message for each in play(frames) if getattr(each.message, "control", 0) == 1]
    assert [(each.channel, each.value) for each in wheel] == [(0, 0), (0, 64), (0, 114), (0, 0)]


def test_before_its_note_a_finger_has_a_channel_and_slides_there(wire: Any) -> None:
    hovering = wire.frame(0, [wire.finger(at=C, hover_mm=25.0)])
    for slide, value in ((Slide.Y, 32), (Slide.HOVER, 64)):
        sent = play([hovering, tap(wire)], slide=slide, hover_control=0)
        assert texts(sent)[0] == f"cc74 {value}"
        assert {each.message.channel for each in sent} == {1}
    assert play([hovering], slide=Slide.OFF, hover_control=0) == []


def test_the_other_hand_s_height_slides_if_one_wants(wire: Any) -> None:
    both = wire.frame(4, [wire.finger(at=C, pressure=0.75), wire.finger(id=2, hover_mm=50.0)])
    slides = [
        each.message
        for each in play([tap(wire), both], slide=Slide.HOVER)
        if getattr(each.message, "control", 0) == 74
    ]
    assert {(each.channel, each.value) for each in slides} >= {(1, 127)}


def theremin(wire: Any, hover_mm: float, number: int, finger: int = 1) -> TouchFrame:
    return wire.frame(
        number, [replace(wire.finger(at=(150.0, 100.0), hover_mm=hover_mm), finger=finger)]
    )


def test_a_theremin_sounds_in_the_air_louder_when_lower(wire: Any) -> None:
    heights = (60.0, 50.0, 25.0, 10.0, 55.0, 60.0)
    frames = [theremin(wire, height, n) for n, height in enumerate(heights)]
    sent = texts(play(frames, "theremin"))
    assert [each for each in sent if each[:2] in ("on", "of")] == ["on 66", "off 66"]
    assert [each for each in sent if each[:2] == "pr"] == [
        "press 0",
        "press 64",
        "press 102",
        "press 0",
    ]
    assert play([theremin(wire, 10.0, 0, finger=2)], "theremin") == [], "the index finger alone"


def test_a_note_that_began_before_the_program_is_not_started_in_its_middle(wire: Any) -> None:
    sent = play(
        [wire.frame(0, [wire.finger(pressure=0.5)]), wire.frame(1, [wire.finger(pressure=0.6)])]
    )
    assert [each for each in texts(sent) if each[:2] == "on"] == []


def read(messages: list[mido.Message]) -> Receiver:
    receiver = Receiver()
    for each in messages:
        receiver.read(each.bytes())
    return receiver


def test_whatever_happens_the_last_messages_leave_silence(wire: Any) -> None:
    player = Player(board("grid"))
    messages = player.opening()
    messages += [each.message for each in player.process(tap(wire))]
    messages += player.closing()
    assert read(messages).end() == []
    assert messages[-2].bytes() == [0xB0, 123, 0]


def test_a_port_that_is_back_gets_its_zone_and_no_note_of_before(wire: Any) -> None:
    player = Player(board("grid"))
    player.opening()
    player.process(tap(wire))
    again = player.opening()
    again += [
        each.message for each in player.process(wire.frame(4, [wire.finger(at=C, pressure=0.9)]))
    ]
    assert read(again).end() == []
    assert not [each for each in again if each.type in ("note_on", "note_off")]


def test_the_zone_is_configured_again_after_a_pause_for_a_synthesiser_that_starts_later(
    wire: Any,
) -> None:
    player = Player(board("grid"), repeats=True)
    player.opening()
    zone = [0xB0, 6, 15]

    def configured(number: int, pointers: list[Pointer]) -> bool:
        return zone in [
            each.message.bytes() for each in player.process(wire.frame(number, pointers))
        ]

    assert not configured(0, [])
    assert not configured(200, [wire.finger(hover_mm=20.0)]), "7 s are too short"
    assert not configured(201, [])
    assert configured(600, [wire.finger(hover_mm=20.0)])
