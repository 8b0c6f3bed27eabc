"""A lower rate loses no touch and looks like a stream of its own."""

from __future__ import annotations

from dataclasses import replace

import pytest

import halo_protocol as wire
from halo_service.outputs.frame_encoder import FrameEncoder
from halo_service.outputs.outgoing import OutgoingFrame
from halo_service.outputs.throttle import Throttle
from halo_service.values import TouchEvent, TouchFrame
from tests.outputs.samples import FRAME_US, TOUCHING, frame


def sent(rate_hz: float, frames: list[OutgoingFrame]) -> list[OutgoingFrame]:
    throttle = Throttle(rate_hz)
    return [each for each in map(throttle.take, frames) if each is not None]


@pytest.mark.parametrize(
    ("rate_hz", "count"), [(5, 50), (10, 100), (20, 200), (30, 300), (60, 300)]
)
def test_the_rate_is_the_mean_over_ten_seconds(rate_hz: float, count: int) -> None:
    assert len(sent(rate_hz, [frame(n) for n in range(300)])) == pytest.approx(count, abs=2)


def test_frames_are_numbered_without_gaps() -> None:
    numbers = [each.header.frame for each in sent(10, [frame(n) for n in range(90)])]
    assert numbers == list(range(numbers[0], numbers[0] + len(numbers)))


def test_a_recording_that_starts_again_is_not_silent() -> None:
    frames = [frame(n) for n in range(90)]
    assert len(sent(10, frames + frames)) == pytest.approx(60, abs=2)


def taps(count: int, again_ms: float = 0.0) -> list[OutgoingFrame]:
    """Four seconds with a touch of 100 ms every 400 ms, repeated events included."""
    encoder = FrameEncoder("desk", "s1", 0, again_ms=again_ms)
    frames = []
    for n in range(count):
        tap, phase = divmod(n, 12)
        events = {
            3: (TouchEvent("down", 7, 0, 150.0, 50.0, 200.0, 5.0, tap + 1),),
            6: (TouchEvent("up", 7, 0, 150.0, 50.0, 0.0, 5.0, tap + 1),),
        }
        touch = TouchFrame(10**15 + n * FRAME_US, "table", 300.0, 200.0, (), events.get(phase, ()))
        encoded = encoder.encode(touch)
        pointer = replace(TOUCHING, state=int(3 <= phase < 6), contacts=tap + (phase >= 3))
        header = replace(encoded.header, count=1)
        frames.append(replace(encoded, header=header, pointers=(pointer,)))
    return frames


@pytest.mark.parametrize("rate_hz", [2, 5, 10, 25])
def test_a_client_counts_each_touch_once_and_at_once(rate_hz: float) -> None:
    assembler = wire.Assembler()
    found: list[tuple[str, int]] = []
    for each in sent(rate_hz, taps(120)):
        for datagram in each.datagrams:
            for event in assembler.receive_data(datagram, 0.0):
                assert isinstance(event, wire.TouchFrame)
                assert event.missed == 0
                assert all(down.ago_ms < 34 for down in event.downs), "an event waited"
                assert all(down.strike_mm_s == 200.0 for down in event.downs), "inferred"
                found += [(type(e).__name__, e.contacts) for e in event.events]
    assert found == [(kind, n) for n in range(1, 11) for kind in ("Down", "Up")]


def test_each_event_is_in_three_of_the_sent_frames() -> None:
    frames = sent(5, taps(120))
    copies = [(down.contacts) for each in frames for down in each.downs]
    assert {copies.count(n) for n in range(1, 9)} == {3}


@pytest.mark.parametrize("rate_hz", [2, 5, 10, 25, 60])
def test_a_late_copy_is_sent_once_more_and_not_ahead_of_its_time(rate_hz: float) -> None:
    without, late = (sent(rate_hz, taps(120, again_ms)) for again_ms in (0.0, 400.0))
    assert len(late) == len(without)
    copies = [(down.contacts) for each in late for down in each.downs]
    assert {copies.count(n) for n in range(1, 9)} == {4}
