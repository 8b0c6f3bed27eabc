"""Which packets make a capture: a table of streams and what comes out of them."""

import pytest

from halo_service.sources.pairing import LOOK_AHEAD_PACKETS, Capture, Pairing

ALL = frozenset({"DEPTH", "IR", "COLOR"})
PERIOD_US = 33_333
D, R, C = "DEPTH", "IR", "COLOR"


def pair(stream, tracks=ALL, delay_us=0.0):
    """Feed (track, time) pairs; give (time, the members' times) for each capture."""
    pairing: Pairing[int] = Pairing(tracks, PERIOD_US, depth_delay_us=delay_us)
    captures: list[Capture[int]] = []
    for track, time_us in stream:
        captures += pairing.push(track, time_us, time_us)
    captures += pairing.flush()
    return [(c.time_us, c.depth, c.ir, c.colour) for c in captures]


CASES = {
    "nothing": ([], []),
    "one capture": ([(C, 10), (D, 10), (R, 10)], [(10, 10, 10, 10)]),
    "in any order": ([(R, 10), (D, 10), (C, 10)], [(10, 10, 10, 10)]),
    "depth rules the time": ([(C, 5000), (D, 9000), (R, 9000)], [(9000, 9000, 9000, 5000)]),
    "time zero is a time": ([(C, 0), (D, 0), (R, 0)], [(0, 0, 0, 0)]),
    "negative time": ([(C, -7), (D, -5), (R, -5)], [(-5, -5, -5, -7)]),
    "two captures": (
        [(C, 0), (D, 0), (R, 0), (C, 33_000), (D, 33_333), (R, 33_333)],
        [(0, 0, 0, 0), (33_333, 33_333, 33_333, 33_000)],
    ),
    "tracks one after the other": (
        [(D, 0), (D, 33_333), (R, 0), (R, 33_333), (C, 0), (C, 33_333)],
        [(0, 0, 0, 0), (33_333, 33_333, 33_333, 33_333)],
    ),
    "no colour this time": (
        [(D, 0), (R, 0), (C, 33_333), (D, 33_333), (R, 33_333)],
        [(0, 0, 0, None), (33_333, 33_333, 33_333, 33_333)],
    ),
    "no depth this time": (
        [(C, 0), (R, 0), (C, 33_333), (D, 33_333), (R, 33_333)],
        [(0, None, 0, 0), (33_333, 33_333, 33_333, 33_333)],
    ),
    "no IR at the end": ([(C, 0), (D, 0)], [(0, 0, None, 0)]),
    "colour alone": ([(C, 0)], [(0, None, None, 0)]),
    "colour half a period off is no partner": (
        [(D, 0), (R, 0), (C, 17_000)],
        [(0, 0, 0, None), (17_000, None, None, 17_000)],
    ),
    "a second depth in the same moment stands alone": (
        [(C, 0), (D, 0), (R, 0), (D, 100)],
        [(0, 0, 0, 0), (100, 100, None, None)],
    ),
}


@pytest.mark.parametrize(("stream", "captures"), CASES.values(), ids=CASES)
def test_a_capture_is_what_is_near_its_depth(stream, captures):
    assert pair(stream) == captures


def test_without_a_colour_track_no_capture_waits_for_one():
    pairing: Pairing[int] = Pairing(frozenset({"DEPTH", "IR"}), PERIOD_US)
    assert list(pairing.push(D, 0, 0)) == []
    assert list(pairing.push(R, 0, 1)) == [Capture(0, 0, 1, None)]


def test_depth_with_a_configured_delay_finds_its_colour():
    stream = [(C, 0), (D, 20_000), (R, 20_000), (C, 33_333), (D, 53_333), (R, 53_333)]
    assert pair(stream, delay_us=20_000) == [
        (20_000, 20_000, 20_000, 0),
        (53_333, 53_333, 53_333, 33_333),
    ]


@pytest.mark.parametrize("step_us", [PERIOD_US, 0, -PERIOD_US])
def test_what_waits_is_bounded_whatever_the_timestamps(step_us):
    pairing: Pairing[int] = Pairing(ALL, PERIOD_US)
    out = 0
    for n in range(1000):
        out += sum(1 for _ in pairing.push(D, n * step_us, n))
    assert out >= 1000 - LOOK_AHEAD_PACKETS
    assert out + sum(1 for _ in pairing.flush()) == 1000


def test_a_whole_capture_is_given_at_once():
    pairing: Pairing[int] = Pairing(ALL, PERIOD_US)
    assert [len(list(pairing.push(t, 0, 0))) for t in (C, D, R)] == [0, 0, 1]
