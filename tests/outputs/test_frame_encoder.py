"""Encoding of the service's frames."""

from __future__ import annotations

from dataclasses import replace

import pytest

import halo_protocol as wire
from halo_service.outputs.frame_encoder import FrameEncoder
from halo_service.outputs.outgoing import OutgoingFrame
from halo_service.values import Diagnostics, Finger, Pointer, Side, Touch, TouchEvent, TouchFrame

FRAME_US = 33_333
NOTHING = Diagnostics((0, 0, 500), (320, 288), 0.0, 0.0, 0.0, 14.0, 45.0, 0.0)
POINTER = Pointer(
    7,
    0,
    Side.RIGHT,
    Finger.INDEX,
    Touch.TOUCH,
    150.0,
    50.0,
    0.0,
    0.5,
    112.5,
    1.0,
    2.0,
    0.9,
    3,
    NOTHING,
)
NEXT = TouchEvent("down", 8, 1, 150.0, 50.0, 300.0, 12.0, 1)
DOWN = TouchEvent("down", 7, 0, 150.0, 50.0, 300.0, 12.0, 3)


def touch_frame(n: int, pointers: tuple[Pointer, ...] = (), *events: TouchEvent) -> TouchFrame:
    return TouchFrame(1_700_000_000_000_000 + n * FRAME_US, "table", 300.0, 200.0, pointers, events)


def messages(frame: OutgoingFrame) -> list[wire.Message]:
    return [message for datagram in frame.datagrams for _, message in wire.decode(datagram)]


def test_a_frame_has_the_values_of_the_service() -> None:
    header, *rest = messages(FrameEncoder("desk", "s1", 41).encode(touch_frame(0, (POINTER,))))
    assert header == wire.Frame("desk", "s1", 41, 1_700_000_000, 0, 1)
    pointer, alive = rest
    assert isinstance(pointer, wire.Pointer)
    assert (pointer.id, pointer.u, pointer.v) == (7, 0.5, 0.25)
    assert (pointer.state, pointer.hand, pointer.finger) == (1, 2, 1)
    assert pointer.force_g == 112.5
    assert alive == wire.Alive((7,))


def test_an_event_is_sent_three_times_with_its_age() -> None:
    frames = FrameEncoder("desk", "s1", 0)
    seen = []
    for n in range(5):
        frame = frames.encode(touch_frame(n, (POINTER,), *([DOWN] if n == 1 else [])))
        seen.append([m for m in messages(frame) if isinstance(m, wire.Down)])
    assert [len(downs) for downs in seen] == [0, 1, 1, 1, 0]
    ages = [downs[0].ago_ms for downs in seen[1:4]]
    assert ages == pytest.approx([12.0, 12.0 + 33.333, 12.0 + 66.666], abs=1e-3)
    assert {downs[0].contacts for downs in seen[1:4]} == {3}


def test_a_client_that_loses_any_two_of_three_datagrams_still_counts_one_hit() -> None:
    for lost in ({1, 2}, {1, 3}, {2, 3}, set()):
        frames, client = FrameEncoder("desk", "s1", 0), wire.Assembler()
        hits = 0
        for n in range(6):
            pointer = replace(POINTER, contacts=3 if n else 2)
            encoded = frames.encode(touch_frame(n, (pointer,), *([DOWN] if n == 1 else [])))
            for datagram in encoded.datagrams:
                if n not in lost:
                    events = client.receive_data(datagram, n / 30)
                    hits += sum(len(e.downs) for e in events if isinstance(e, wire.TouchFrame))
        assert hits == 1, lost


@pytest.mark.parametrize("pause_from", range(12))
def test_with_one_copy_more_a_wifi_that_pauses_for_300_ms_hides_no_hit(pause_from: int) -> None:
    """The finger taps and leaves, so that no pointer shows it later."""
    frames, client = FrameEncoder("desk", "s1", 0, again_ms=400.0), wire.Assembler()
    found: list[str] = []
    up = replace(DOWN, kind="up", strike_mm_s=0.0)
    for n in range(40):
        pointers = (POINTER,) if 10 <= n < 13 else ()
        events = {10: (DOWN,), 13: (up,)}.get(n, ())
        for datagram in frames.encode(touch_frame(n, pointers, *events)).datagrams:
            if not pause_from <= n < pause_from + 9:
                for event in client.receive_data(datagram, n / 30):
                    assert isinstance(event, wire.TouchFrame)
                    found += [type(each).__name__ for each in event.events]
    assert found == ["Down", "Up"]


def test_after_time_went_back_old_events_are_forgotten_and_new_ones_sent_again() -> None:
    frames = FrameEncoder("desk", "s1", 0, again_ms=400.0)
    frames.encode(touch_frame(200, (POINTER,), DOWN))
    sent = [frames.encode(touch_frame(n, (), *([NEXT] if n == 3 else []))) for n in range(30)]
    assert [n for n, each in enumerate(sent) if NEXT.id in {down.id for down in each.downs}] == [
        3, 4, 5, 16,
    ]  # fmt: skip
    assert all(down.id == NEXT.id for each in sent[2:] for down in each.downs)


def test_the_session_time_starts_at_the_first_frame() -> None:
    frames = FrameEncoder("desk", "s1", 0)
    headers = [messages(frames.encode(touch_frame(n)))[0] for n in (7, 8, 37)]
    assert [h.session_ms for h in headers if isinstance(h, wire.Frame)] == [0, 33, 999]


def test_frames_count_up() -> None:
    frames = FrameEncoder("desk", "s1", 2**24 - 1)
    numbers = [messages(frames.encode(touch_frame(n)))[0] for n in range(2)]
    assert [header.frame for header in numbers if isinstance(header, wire.Frame)] == [2**24 - 1, 0]
