"""What a receiver reports becomes the messages of the service again."""

from __future__ import annotations

from dataclasses import replace

import halo_protocol as wire
from halo_service.app.bridge.relay import COPIES, Relay
from halo_service.outputs.outgoing import Outgoing, OutgoingFrame
from tests.outputs.samples import TOUCHING, fingers, frame

SCENES = {("desk", "table"): wire.Scene("desk", "s1", wire.VERSION, 600.0, 400.0, 2, 0, 0, 30.0)}
DOWN = wire.Down(7, 0, 0.5, 0.25, 180.0, 12.0, 3)


class Path:
    """Datagrams in, what is sent out, as in a lane."""

    def __init__(self, *, with_node: bool = False) -> None:
        self.relay = Relay(with_node=with_node)
        self._assembler = wire.Assembler()

    def take(self, datagrams: list[bytes], now_s: float = 0.0) -> list[Outgoing]:
        sent: list[Outgoing] = []
        for datagram in datagrams:
            self.relay.read(datagram)
            events = self._assembler.receive_data(datagram, now_s)
            sent += self.relay.outgoing(events, SCENES)
        return sent

    def wait(self, now_s: float) -> list[Outgoing]:
        return list(self.relay.outgoing(self._assembler.expire(now_s), SCENES))


def bytes_of(sent: list[Outgoing]) -> list[bytes]:
    return [datagram for each in sent for datagram in each.datagrams]


def test_split_frames_and_each_copy_of_an_event_have_the_bytes_of_the_service() -> None:
    path = Path()
    late = replace(DOWN, ago_ms=45.0)
    for sent in (frame(1, (TOUCHING,), (DOWN,)), frame(2, (TOUCHING,), (late,))):
        assert bytes_of(path.take(sent.datagrams)) == sent.datagrams
    split = frame(3, fingers(20), (replace(DOWN, ago_ms=78.0),))
    assert len(split.datagrams) > 1
    assert bytes_of(path.take(split.datagrams)) == split.datagrams


def test_the_size_of_the_surface_is_that_of_its_scene() -> None:
    (sent,) = Path().take(frame(1).datagrams)
    assert isinstance(sent, OutgoingFrame)
    assert sent.size_mm == (600.0, 400.0)


def test_a_lost_node_ends_its_touches_in_newer_frames_without_pointers() -> None:
    path = Path()
    path.take(frame(5, (TOUCHING,), (DOWN,)).datagrams)
    sent = path.wait(3.5)
    assert [each.header.frame for each in sent if isinstance(each, OutgoingFrame)] == [6, 7, 8]
    assert len(sent) == COPIES
    for each in sent:
        assert isinstance(each, OutgoingFrame)
        assert each.pointers == ()
        assert [up.contacts for up in each.ups] == [TOUCHING.contacts]
    assert path.wait(10.0) == []


def test_gaps_are_counted_also_where_the_node_was_lost_in_between_but_not_over_a_restart() -> None:
    path = Path()
    path.take(frame(1, (TOUCHING,)).datagrams)
    path.take(frame(4, (TOUCHING,)).datagrams)
    assert path.relay.missed == 2
    path.wait(3.5)
    path.take(frame(304, (TOUCHING,)).datagrams, 13.0)
    assert (path.relay.frames, path.relay.missed) == (3, 2 + 299)
    restarted = frame(9, (TOUCHING,))
    restarted = replace(restarted, header=replace(restarted.header, session="s2"))
    path.take(restarted.datagrams, 13.1)
    assert path.relay.missed == 2 + 299


def test_of_several_nodes_each_surface_has_its_node_in_its_name() -> None:
    path = Path(with_node=True)
    scene = wire.encode("table", SCENES["desk", "table"])
    sent = path.take([scene, *frame(1, (TOUCHING,)).datagrams])
    assert [each.surface for each in sent] == ["desk-table", "desk-table"]


def test_bad_datagrams_and_endless_parts_cost_little_memory() -> None:
    relay = Relay()
    relay.read(b"#bundle\0rubbish")
    for number in range(100):
        relay.read(frame(number, (TOUCHING,), (DOWN,)).datagrams[0])
    assert len(relay._copies) <= 8
