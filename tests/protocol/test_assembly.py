"""Assembly: the golden sequences, and properties beyond them."""

import json
from collections.abc import Iterable, Sequence
from contextlib import nullcontext
from dataclasses import replace
from itertools import combinations
from typing import Any

import pytest

from halo_protocol import (
    MAX_EVENTS,
    UNKNOWN_STRIKE,
    Assembler,
    Down,
    Frame,
    Lost,
    Pointer,
    ProtocolError,
    TouchFrame,
    Up,
    encode,
    encode_frame,
    event_to_json,
)
from halo_protocol.assembly import MAX_STREAMS
from halo_protocol.osc import IMMEDIATELY, bundle, message_spans
from halo_protocol.touch_counter import MAX_REMEMBERED
from tests.golden import VECTORS

SEQUENCES = [
    pytest.param(vector["steps"], id=vector["name"])
    for vector in json.loads((VECTORS / "assembly.json").read_text())["vectors"]
]
POINTER = Pointer(1, 0, 2, 1, 0, 0.5, 0.5, 150.0, 100.0, 3.0, 0.0, 0.0, 0.0, 1.0, 0, -1.0)


def frame(
    number: int,
    pointers: Sequence[Pointer] = (),
    downs: Iterable[Down] = (),
    ups: Iterable[Up] = (),
    node: str = "desk",
    session: str = "s1",
) -> list[bytes]:
    header = Frame(node, session, number, number, 0, len(pointers))
    return encode_frame("table", header, list(pointers), list(downs), list(ups))


@pytest.mark.parametrize("steps", SEQUENCES)
def test_the_events_are_those_of_the_golden_files(steps: list[dict[str, Any]]) -> None:
    assembler = Assembler()
    for step in steps:
        if step["hex"] is None:
            events = assembler.expire(step["at_s"])
        elif "refusal" in step:
            with pytest.raises(ProtocolError) as refused:
                assembler.receive_data(bytes.fromhex(step["hex"]), step["at_s"])
            assert str(refused.value) == step["refusal"]
            continue
        else:
            events = assembler.receive_data(bytes.fromhex(step["hex"]), step["at_s"])
        assert [event_to_json(event) for event in events] == step["events"]


def ten_frames() -> list[list[bytes]]:
    """Ten frames: a finger comes, taps twice (once within a frame), touches and leaves."""
    first, second, third = (Down(1, 0, 0.5, 0.5, 100.0 * n, 5.0, n) for n in (1, 2, 3))
    lift, second_lift, last_lift = (Up(1, 0, 0.5, 0.5, 3.0, n) for n in (1, 2, 3))
    hover = [replace(POINTER, contacts=n) for n in range(4)]
    touch = [replace(POINTER, state=1, hover_mm=0.0, pressure=1.0, contacts=n) for n in range(4)]
    return [
        frame(0),
        frame(1, [hover[0]]),
        frame(2, [touch[1]], [first]),
        frame(3, [hover[1]], [first], [lift]),
        frame(4, [hover[2]], [first, second], [lift, second_lift]),
        frame(5, [touch[3]], [second, third], [lift, second_lift]),
        frame(6, [touch[3]], [second, third], [second_lift]),
        frame(7, [], [third], [last_lift]),
        frame(8, [], [], [last_lift]),
        frame(9, [], [], [last_lift]),
    ]


def assembled(frames: list[list[bytes]]) -> list[TouchFrame]:
    assembler = Assembler()
    datagrams = [datagram for datagrams in frames for datagram in datagrams]
    events = [event for datagram in datagrams for event in assembler.receive_data(datagram, 0.0)]
    return [event for event in events if isinstance(event, TouchFrame)]


def notes(events: Iterable[TouchFrame]) -> list[tuple[str, int]]:
    return [("down" if isinstance(e, Down) else "up", e.contacts) for f in events for e in f.events]


def test_every_touch_is_reported_once_and_in_order() -> None:
    expected = [(kind, number) for number in (1, 2, 3) for kind in ("down", "up")]
    assert notes(assembled(ten_frames())) == expected


@pytest.mark.parametrize("lost", [set(s) for n in (1, 2) for s in combinations(range(1, 9), n)])
def test_two_lost_frames_lose_no_touch_and_no_strike(lost: set[int]) -> None:
    events = assembled([f for i, f in enumerate(ten_frames()) if i not in lost])
    assert notes(events) == [(kind, n) for n in (1, 2, 3) for kind in ("down", "up")]
    strikes = [down.strike_mm_s for event in events for down in event.downs]
    assert strikes == [100.0, 200.0, 300.0]


@pytest.mark.parametrize("lost", [set(s) for n in (3, 5, 7) for s in combinations(range(1, 9), n)])
def test_whatever_is_lost_downs_and_ups_alternate_and_nothing_sticks(lost: set[int]) -> None:
    events = assembled([f for i, f in enumerate(ten_frames()) if i not in lost])
    reported = notes(events)
    assert reported[::2] == [("down", number) for _, number in reported[::2]]
    assert reported[1::2] == [("up", number) for _, number in reported[::2]]
    assert len(reported) % 2 == 0
    assert events[-1].pointers == ()
    assert sum(event.missed for event in events) == len(lost)


def test_datagrams_in_any_order_never_go_back() -> None:
    frames = ten_frames()
    shuffled = [frames[i] for i in (0, 2, 1, 3, 5, 4, 4, 6, 8, 7, 9, 0)]
    numbers = [event.frame for event in assembled(shuffled)]
    assert numbers == sorted(set(numbers))
    assert notes(assembled(shuffled)) == [(k, n) for n in (1, 2, 3) for k in ("down", "up")]


def test_old_parts_are_counted() -> None:
    assembler = Assembler()
    for number in (1, 2, 2, 1, 3):
        assembler.receive_data(frame(number)[0], 0.0)
    assert assembler.dropped == 2
    assembler.expire(10.0)
    assert assembler.dropped == 2


def test_a_sender_with_many_sessions_does_not_fill_the_memory() -> None:
    assembler = Assembler()
    events = []
    for number in range(10 * MAX_STREAMS):
        forged = frame(1, [POINTER], node=f"n{number}")[0]
        events += assembler.receive_data(forged, number / 1000)
        # A session that sends all the time is not closed.
        events += assembler.receive_data(frame(number, [POINTER])[0], number / 1000)
    lost = [event.node for event in events if isinstance(event, Lost)]
    assert len(lost) == 9 * MAX_STREAMS + 1
    assert "desk" not in lost


def test_a_session_with_many_ids_does_not_fill_the_memory() -> None:
    assembler = Assembler()
    for number in range(20):
        ids = range(number * 100, number * 100 + 100)
        downs = [Down(i, 0, 0.5, 0.5, 1.0, 1.0, 1) for i in ids]
        for datagram in frame(number, [], downs):
            assembler.receive_data(datagram, 0.0)
    (stream,) = assembler._streams.values()
    assert len(stream._touches._touches) <= MAX_REMEMBERED + 100


def test_a_frame_that_never_ends_does_not_fill_the_memory() -> None:
    assembler = Assembler()
    empty = elements(encode_frame("table", Frame("desk", "s1", 1, 1, 0, 1), [POINTER])[0])
    for number in range(10):
        events = [up_alone(100 * number + i) for i in range(100)]
        assembler.receive_data(bundle(IMMEDIATELY, empty[0], *events, empty[-1]), 0.0)
    assert assembler.dropped == 8


def test_a_datagram_of_too_many_events_is_refused() -> None:
    empty = elements(frame(1)[0])
    for count, refused in ((MAX_EVENTS, False), (MAX_EVENTS + 1, True)):
        events = [up_alone(i) for i in range(count)]
        datagram = bundle(IMMEDIATELY, empty[0], *events, empty[-1])
        with pytest.raises(ProtocolError, match="256") if refused else nullcontext():
            Assembler().receive_data(datagram, 0.0)


def elements(datagram: bytes) -> list[bytes]:
    return [datagram[start:end] for start, end in message_spans(datagram)]


def up_alone(number: int) -> bytes:
    return elements(encode("table", Up(number, 0, 0.5, 0.5, 3.0, 1)))[0]


def test_an_open_touch_of_a_silent_service_is_ended() -> None:
    assembler = Assembler(timeout_s=1.0)
    touch = replace(POINTER, state=1, contacts=4)
    assembler.receive_data(frame(1, [touch], [Down(1, 0, 0.5, 0.5, 1.0, 1.0, 4)])[0], 10.0)
    assert assembler.expire(11.0) == []
    closing, lost = assembler.expire(11.1)
    assert isinstance(closing, TouchFrame)
    assert closing.pointers == ()
    assert [up.contacts for up in closing.ups] == [4]
    assert lost == Lost("table", "desk", "s1")
    assert assembler.expire(100.0) == []


@pytest.mark.parametrize(
    ("pointers", "left", "lost_s"),
    [
        ([POINTER], {"desk"}, 0.5),
        ([POINTER], {"other"}, 3.0),
        ([], {"desk"}, 3.0),  # it may send one frame a second only
    ],
)
def test_a_node_that_has_left_is_lost_after_half_a_second_with_pointers(
    pointers: list[Pointer], left: set[str], lost_s: float
) -> None:
    assembler = Assembler()
    for datagram in frame(1, pointers):
        assembler.receive_data(datagram, 1.0)
    assembler.left = frozenset(left)
    assert assembler.expire(1.0 + lost_s) == []
    assert assembler.expire(1.01 + lost_s)[-1] == Lost("table", "desk", "s1")


def test_an_inferred_down_is_marked() -> None:
    (down,) = assembled([frame(0), frame(9, [replace(POINTER, state=1, contacts=1)])])[-1].downs
    assert down == Down(1, 0, 0.5, 0.5, UNKNOWN_STRIKE, 0.0, 1)
