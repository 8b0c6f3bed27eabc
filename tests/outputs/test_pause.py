"""A Wi-Fi that pauses for 0.3 s hides no touch from a client, with the default settings."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import pytest

import halo_protocol as wire
from halo_service.outputs.destination import parse_destination
from halo_service.outputs.frame_encoder import FrameEncoder
from halo_service.outputs.outgoing import OutgoingFrame
from halo_service.outputs.settings import OscSettings
from halo_service.outputs.stream_encoder import StreamEncoder
from halo_service.values import TouchEvent, TouchFrame
from tests.outputs.samples import FRAME_US

TAPS = 4
CYCLE = 20
"""Frames from tap to tap; each time the finger has left meanwhile, so that nothing is inferred."""
PAUSED = 9
"""Lost frames: 0.3 s."""
WANTED = [(kind, 10 + tap) for tap in range(TAPS) for kind in ("Down", "Up")]


def tapping(again_ms: float) -> Iterator[OutgoingFrame]:
    """Taps of 0.1 s by fingers that come and go between two frames."""
    encoder = FrameEncoder("desk", "s1", 0, again_ms=again_ms)
    for n in range(TAPS * CYCLE + 20):
        tap, phase = divmod(n, CYCLE)
        kind = {3: "down", 6: "up"}.get(phase) if tap < TAPS else None
        strike = 200.0 if kind == "down" else 0.0
        events = () if kind is None else (
            TouchEvent(kind, 10 + tap, 0, 150.0, 50.0, strike, 5.0, 1),  # type: ignore[arg-type]
        )  # fmt: skip
        yield encoder.encode(TouchFrame(n * FRAME_US, "table", 300.0, 200.0, (), events))


def arrived(options: str, pause: range, again_ms: float) -> list[bytes]:
    """The datagrams that a pause of the network leaves."""
    stream = StreamEncoder(parse_destination(f"127.0.0.1:1{options}").stream)
    sent = [(n, stream.datagrams(frame)) for n, frame in enumerate(tapping(again_ms))]
    return [datagram for n, datagrams in sent if n not in pause for datagram in datagrams]


def by_the_library(datagrams: list[bytes]) -> list[tuple[str, int]]:
    """What the client library reports. Where the pause ends between down and up, it infers the down
    from the up, and the strength is lost."""
    assembler, found = wire.Assembler(), []
    for datagram in datagrams:
        for event in assembler.receive_data(datagram, 0.0):
            assert isinstance(event, wire.TouchFrame)
            found += [(type(each).__name__, each.id) for each in event.events]
    return found


def by_id_and_number(datagrams: list[bytes]) -> list[tuple[str, int]]:
    """What a client counts that looks at the messages alone, as SPEC.md demands."""
    seen = {}
    for datagram in datagrams:
        for _, message in wire.decode(datagram):
            if isinstance(message, wire.Down | wire.Up):
                seen[type(message).__name__, message.id, message.contacts] = None
    return [(kind, number) for kind, number, _ in seen]


RECEIVERS: dict[str, Callable[[list[bytes]], list[tuple[str, int]]]] = {
    "": by_the_library,
    "/frames,rate=10": by_the_library,
    "/frames,rate=25": by_the_library,
    "/frames,timetags=on": by_the_library,
    "/frames,bundles=off": by_id_and_number,
}


@pytest.mark.parametrize("options", RECEIVERS)
@pytest.mark.parametrize("first_lost", range(CYCLE))
def test_each_touch_is_counted_once(options: str, first_lost: int) -> None:
    pause = range(CYCLE + first_lost, CYCLE + first_lost + PAUSED)
    found = RECEIVERS[options](arrived(options, pause, OscSettings().again_ms))
    assert sorted(found) == sorted(WANTED)
    assert found == WANTED or options == "/frames,bundles=off"  # which has no order to rely on


def test_without_the_late_copy_the_pause_hides_touches() -> None:
    lost = 0
    for first_lost in range(CYCLE):
        pause = range(CYCLE + first_lost, CYCLE + first_lost + PAUSED)
        lost += len(WANTED) - len(by_the_library(arrived("", pause, 0.0)))
    assert lost == 2 * 4, "in four of twenty phases all copies of a down and of its up are lost"


@pytest.mark.parametrize("name", ["flat", "flat,changes=on", "tuio11", "tuio2"])
def test_what_has_no_numbers_for_touches_is_right_again_with_the_first_frame(name: str) -> None:
    """These formats say what is, not what was: a tap within the pause is not in them."""
    stream = StreamEncoder(parse_destination(f"127.0.0.1:1/{name}").stream)
    fresh = StreamEncoder(parse_destination(f"127.0.0.1:1/{name}").stream)
    sent = [stream.datagrams(frame) for frame in tapping(400.0)]
    late = [fresh.datagrams(frame) for frame in tapping(0.0)]
    assert sent == late, "a late copy must not hit twice where no number tells that it is late"
