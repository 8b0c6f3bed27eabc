"""What a client of a canvas gets while fingers cross its seams."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
import pytest

import halo_protocol as wire
from benchmarks.merging.nodes import Arrival, Errors, SimulatedNode
from benchmarks.merging.run import HEIGHT_MM, START_US, in_order, simulated, table
from benchmarks.merging.truth import Finger, Truth
from halo_service.canvas.canvas import Canvas
from halo_service.canvas.layout import Layout, PlacedSurface
from halo_service.outputs.frame_encoder import FrameEncoder
from halo_service.values import Side, Touch, TouchFrame

SEAM_MM = 280.0
EXACT = Errors(
    bias_mm=0.0, noise_mm=0.0, lost_per_s=0.0, missed=0.0, event_ms=0.0, clock_s=0.0, drift=0.0,
    jitter_ms=0.5, pauses=0.0, lost_frames=0.0,
)  # fmt: skip
SLIDE = Finger(((0.5, 180.0, 100.0), (0.8, 180.0, 100.0), (1.6, 380.0, 100.0)), ((0.6, 1.5),))


@dataclass
class Run:
    """A canvas of two nodes that see some fingers."""

    fingers: Sequence[Finger]
    errors: Errors = EXACT
    seed: int = 1

    def __post_init__(self) -> None:
        layout, rectangles, _ = table(2)
        self.canvas = Canvas(layout)
        self.nodes = [
            SimulatedNode(f"node{i}", each, np.random.default_rng((self.seed, i)), self.errors)
            for i, each in enumerate(rectangles)
        ]
        for node in self.nodes:
            node.peers = [each for each in self.nodes if each is not node]
        self.truth = Truth(list(self.fingers), max(each.span_s[1] for each in self.fingers) + 0.5)
        self.assembler = wire.Assembler()

    def arrivals(self) -> Iterator[Arrival]:
        for node in self.nodes:
            where = (node.name, "table")
            self.canvas.scene(where, node.scene)
            self.canvas.health(where, node.health)
        return in_order(self.nodes, self.truth)

    def frames(self) -> list[TouchFrame]:
        return [frame for each in self.arrivals() for frame in self.receive(each)]

    def receive(self, arrival: Arrival, session: str = "") -> list[TouchFrame]:
        sent = []
        for event in self.assembler.receive_data(arrival.datagram, arrival.arrival_s):
            if isinstance(event, wire.TouchFrame):
                event = replace(event, session=session or event.session)
                frame = self.canvas.arrived(event, START_US + round(arrival.arrival_s * 1e6))
                sent += [frame] if frame is not None else []
        return sent


def events(frames: Sequence[TouchFrame]) -> list[tuple[str, int, int]]:
    return [(e.kind, e.id, e.contacts) for frame in frames for e in frame.events]


def ids(frames: Sequence[TouchFrame]) -> set[int]:
    return {pointer.id for frame in frames for pointer in frame.pointers}


def test_a_touch_that_slides_over_the_seam_is_one_touch_of_one_finger() -> None:
    frames = Run([SLIDE]).frames()
    assert events(frames) == [("down", 1, 1), ("up", 1, 1)]
    assert ids(frames) == {1}
    touching = [f for f in frames if f.pointers and f.pointers[0].state is Touch.TOUCH]
    places = [f.pointers[0].x_mm for f in touching]
    assert places[0] < SEAM_MM - 80 < SEAM_MM + 70 < places[-1]
    assert {(p.slot, p.contacts, p.side) for f in touching for p in f.pointers} == {
        (0, 1, Side.RIGHT)
    }


def test_no_jump_at_the_seam_although_the_nodes_disagree_by_6_mm() -> None:
    run = Run([SLIDE])
    for node, off_mm in zip(run.nodes, (-3.0, 3.0), strict=True):
        node.bias = np.array((0.0, off_mm))
    y_mm = [frame.pointers[0].y_mm for frame in run.frames() if frame.pointers]
    assert min(y_mm) == pytest.approx(97.0, abs=0.5)
    assert max(y_mm) == pytest.approx(103.0, abs=0.5)
    assert np.abs(np.diff(y_mm)).max() < 2.0


def test_a_tap_on_the_seam_is_one_tap() -> None:
    tap = Finger(((0.5, SEAM_MM - 5.0, 80.0), (1.5, SEAM_MM + 5.0, 80.0)), ((0.9, 1.0),))
    frames = Run([tap]).frames()
    assert events(frames) == [("down", 1, 1), ("up", 1, 1)]
    (down,) = [e for frame in frames for e in frame.events if e.kind == "down"]
    assert math.dist((down.x_mm, down.y_mm), tap.place_mm(0.9)) < 1.0


def test_quick_taps_on_the_seam_stay_apart() -> None:
    times = [0.8 + 0.13 * number for number in range(6)]
    taps = Finger(((0.5, SEAM_MM, 80.0), (2.0, SEAM_MM, 80.0)), tuple((t, t + 0.06) for t in times))
    frames = Run([taps]).frames()
    expected = [(kind, 1, number + 1) for number in range(6) for kind in ("down", "up")]
    assert events(frames) == expected


def test_a_tap_that_one_node_misses_is_counted() -> None:
    tap = Finger(((0.5, SEAM_MM, 80.0), (1.5, SEAM_MM, 80.0)), ((0.9, 1.0),))
    run = Run([tap], replace(EXACT, missed=1.0))
    assert events(run.frames()) == [("down", 1, 1), ("up", 1, 1)]


def test_two_fingers_side_by_side_near_the_seam_stay_two() -> None:
    middle = replace(
        SLIDE, corners=tuple((t, x + 14.0, y + 14.0) for t, x, y in SLIDE.corners), finger=2
    )
    frames = Run([SLIDE, middle]).frames()
    assert ids(frames) == {1, 2}
    fingers = {(p.id, int(p.finger)) for frame in frames for p in frame.pointers}
    assert len(fingers) == 2
    assert sorted(events(frames)) == [("down", 1, 1), ("down", 2, 1), ("up", 1, 1), ("up", 2, 1)]


def test_one_hand_over_two_cameras_has_one_side() -> None:
    thumb = Finger(((0.5, 200.0, 130.0), (2.0, 200.0, 130.0)), (), finger=0)
    index = Finger(((0.5, SEAM_MM, 100.0), (2.0, SEAM_MM, 100.0)), (), finger=1)
    little = Finger(((0.5, 340.0, 120.0), (2.0, 340.0, 120.0)), (), finger=4)
    run = Run([thumb, index, little])
    run.nodes[1]._pointer = lambda *of: replace(  # type: ignore[method-assign]
        SimulatedNode._pointer(run.nodes[1], *of), side=Side.LEFT
    )
    frames = run.frames()
    (last,) = [frame for frame in frames if len(frame.pointers) == 3][-1:]
    assert len(ids(frames)) == 3
    assert len({pointer.side for pointer in last.pointers}) == 1


@pytest.mark.parametrize("held_by_both", [False, True])
def test_a_node_that_dies_in_mid_touch_takes_only_its_part(held_by_both: bool) -> None:
    x_mm = SEAM_MM if held_by_both else 150.0
    held = Finger(((0.5, x_mm, 60.0), (3.0, x_mm, 60.0)), ((0.6, 2.9),))
    other = Finger(((0.5, 450.0, 150.0), (3.0, 450.0, 150.0)), ((0.7, 2.9),))
    run = Run([held, other])
    frames = []
    for each in run.arrivals():
        if each.node == "node0" and each.arrival_s > 1.5:
            frame = run.canvas.lost(("node0", "table"), START_US + 1_510_000)
            frames += [frame] if frame is not None else []
        else:
            frames += run.receive(each)
    ended = [
        (e.id, (f.time_us - START_US) / 1e6) for f in frames for e in f.events if e.kind == "up"
    ]
    assert len(ids(frames)) == 2
    early = [id_ for id_, at_s in ended if at_s < 2.0]
    held_id = next(e.id for f in frames for e in f.events if e.y_mm < 100.0)
    assert early == ([] if held_by_both else [held_id])
    assert len(ended) == 2
    after = [frame for frame in frames if (frame.time_us - START_US) / 1e6 > 1.6]
    assert all(any(p.x_mm > 400.0 for p in f.pointers) for f in after[:30])


def test_a_clock_that_is_5_s_off_and_drifts_makes_no_difference() -> None:
    run = Run([replace(SLIDE)])
    run.nodes[1].clock_s, run.nodes[1].drift = 5.0, 100e-6
    frames = run.frames()
    assert events(frames) == [("down", 1, 1), ("up", 1, 1)]
    off_mm = [
        f.pointers[0].x_mm - SLIDE.place_mm((f.time_us - START_US) / 1e6)[0]
        for f in frames
        if f.pointers and f.pointers[0].x_mm < 370.0
    ]
    assert np.percentile(np.abs(off_mm), 95) < 5.0
    assert (np.diff([frame.time_us for frame in frames]) > 0).all()


def test_a_node_that_restarts_starts_afresh_and_leaves_nothing() -> None:
    still = Finger(((0.5, 100.0, 60.0), (3.0, 100.0, 60.0)), ((0.6, 2.9),))
    run = Run([still])
    frames = []
    for each in run.arrivals():
        again = each.node == "node0" and each.arrival_s > 1.5
        if not (each.node == "node0" and 1.5 < each.arrival_s < 1.8):
            frames += run.receive(each, "safter" if again else "")
    assert events(frames) == [("down", 1, 1), ("up", 1, 1), ("down", 2, 1), ("up", 2, 1)]
    assert frames[-1].pointers == ()
    assert run.canvas.nodes["node0", "table"].session == "safter"


def test_a_canvas_of_canvases_merges_four_nodes() -> None:
    _, rectangles, seams = table(4)
    way = Finger(((0.5, 50.0, 100.0), (3.5, 1000.0, 100.0)), ((0.7, 3.3),))
    nodes = [
        SimulatedNode(f"node{i}", each, np.random.default_rng(i), EXACT)
        for i, each in enumerate(rectangles)
    ]
    halves = [
        Canvas(Layout(560.0, HEIGHT_MM, (PlacedSurface(one), PlacedSurface(other, x_mm=260.0))))
        for one, other in (("node0", "node1"), ("node2", "node3"))
    ]
    encoders = [FrameEncoder(name, f"s{name}", 0) for name in ("west", "east")]
    whole = Canvas(
        Layout(1080.0, HEIGHT_MM, (PlacedSurface("west"), PlacedSurface("east", x_mm=520.0)))
    )
    for node in nodes:
        halves[node.name > "node1"].scene((node.name, "table"), node.scene)
    for name in ("west", "east"):
        scene = replace(nodes[0].scene, node=name, session=f"s{name}", width_mm=560.0)
        whole.scene((name, "table"), scene)
    assemblers = wire.Assembler(), wire.Assembler()
    frames = []
    for each in in_order(nodes, Truth([way], 4.0)):
        arrival_us = START_US + round(each.arrival_s * 1e6)
        half = each.node > "node1"
        for event in assemblers[0].receive_data(each.datagram, each.arrival_s):
            sent = (
                halves[half].arrived(event, arrival_us)
                if isinstance(event, wire.TouchFrame)
                else None
            )
            if sent is None:
                continue
            for datagram in encoders[half].encode(sent).datagrams:
                for got in assemblers[1].receive_data(datagram, each.arrival_s):
                    assert isinstance(got, wire.TouchFrame)
                    frame = whole.arrived(got, arrival_us)
                    frames += [frame] if frame is not None else []
    assert events(frames) == [("down", 1, 1), ("up", 1, 1)]
    assert ids(frames) == {1}
    assert max(p.x_mm for f in frames for p in f.pointers) > 900.0
    assert len(seams) == 3


def test_what_others_send_is_ignored() -> None:
    run = Run([SLIDE])
    stranger = wire.TouchFrame("table", "other", "s1", 1, START_US, ())
    assert run.canvas.arrived(stranger, START_US) is None
    assert run.canvas.lost(("other", "table"), START_US) is None


def test_without_nodes_a_frame_is_sent_twice_a_second() -> None:
    canvas = Run([SLIDE]).canvas
    sent = [canvas.tick(START_US + number * 100_000) for number in range(21)]
    assert sum(frame is not None for frame in sent) == 5


@pytest.mark.parametrize(("nodes", "crossings"), [(2, 40), (4, 20)])
def test_realistic_nodes_are_merged_within_the_goals(nodes: int, crossings: int) -> None:
    """Few crossings; `benchmarks/canvas.py` has 500."""
    result = simulated(nodes, crossings, 7)
    assert (result.doubled, result.lost) == (0, 0), result.wrong
    assert result.kept / result.crossings >= 0.99, result.wrong
    assert np.percentile(result.off_mm, 95) < 5.0
    assert np.median(result.late_ms) < 33.3
