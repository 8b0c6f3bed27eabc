"""A layout is found from what nodes report, and the merged surface is drawn."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path

import cv2
import numpy as np
import pytest

import halo_protocol as wire
from benchmarks.merging.nodes import Errors, SimulatedNode
from benchmarks.merging.run import START_US, in_order, table
from benchmarks.merging.truth import Finger, Truth
from halo_service.app.canvas.draw import Drawer, save
from halo_service.app.canvas.find import Collector, by_touch
from halo_service.app.cli import main
from halo_service.app.following import received_events
from halo_service.canvas.detections import SurfaceKey
from halo_service.canvas.finding.placing import placed
from halo_service.canvas.picture import colour
from halo_service.errors import UserError

PLACES = ((265.0, 20.0), (295.0, 60.0), (270.0, 110.0), (292.0, 150.0), (275.0, 185.0))
CLOCKS = Errors(clock_s=5.0, drift=50e-6, lost_per_s=0.0, missed=0.0)


def tapped(collector: Collector, places: tuple[tuple[float, float], ...], now: list[int]) -> None:
    """Touch places in the overlap of two nodes, and note what both report."""
    corners = [(3.0 * n + t, x, y) for n, (x, y) in enumerate(places, 1) for t in (0.0, 2.0)]
    touches = tuple((3.0 * n + 0.5, 3.0 * n + 1.1) for n in range(1, len(places) + 1))
    _, rectangles, _ = table(2)
    nodes = [
        SimulatedNode(f"node{i}", each, np.random.default_rng(i), CLOCKS)
        for i, each in enumerate(rectangles)
    ]
    assembler = wire.Assembler()
    for node in nodes:
        collector.handle((node.name, "table"), [wire.Report("table", node.scene)])
    truth = Truth([Finger(tuple(corners), touches)], 3.0 * len(places) + 4.0)
    for each in in_order(nodes, truth):
        now[0] = START_US + round(each.arrival_s * 1e6)
        events = assembler.receive_data(each.datagram, each.arrival_s)
        collector.handle((each.node, "table"), events)


def test_touches_of_both_cameras_give_the_layout() -> None:
    surfaces: list[SurfaceKey] = [("node0", "table"), ("node1", "table")]
    now = [0]
    collector = Collector(surfaces, lambda: now[0])
    tapped(collector, PLACES, now)
    layout, away = placed(collector.sizes_mm, by_touch(collector, 5, 1.0))
    assert not away
    _, second = layout.surface
    assert abs(second.x_mm - layout.surface[0].x_mm - 260.0) < 6.0
    assert abs(second.angle_deg) < 3.0


@pytest.mark.parametrize(
    ("places", "touches", "says"),
    [
        (PLACES[:2], 3, "2 of 3 touches were seen by two cameras"),
        (((280.0, 90.0), (282.0, 91.0), (281.0, 92.0), (283.0, 89.0)), 4, "touch"),
    ],
)
def test_too_few_touches_or_places_too_near_are_refused_with_the_remedy(
    places: tuple[tuple[float, float], ...], touches: int, says: str
) -> None:
    now = [0]
    collector = Collector([("node0", "table"), ("node1", "table")], lambda: now[0])
    tapped(collector, places, now)
    with pytest.raises(UserError, match=says):
        by_touch(collector, touches, 0.3)


@pytest.mark.parametrize(
    ("options", "says"),
    [
        (["--node", "a"], "name two or more different services"),
        (["--node", "a", "--node", "a"], "name two or more different services"),
        (["--node", "A", "--node", "b"], "write --node NAME or NAME/SURFACE"),
        (["--node", "a", "--node", "b", "--touches", "2"], "--touches must be 3 or more"),
        (["--node", "a", "--node", "b", "--out", "{file}"], "add --force to replace it"),
        (["--node", "a", "--node", "b", "--out", "{folder}"], "is a folder; name a file"),
        (["--node", "a", "--node", "b", "--connect", "nonsense"], "tcp/HOST:PORT"),
    ],
)
def test_wrong_options_of_find_are_one_sentence(
    options: list[str], says: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (file := tmp_path / "table.toml").write_text("")
    assert (
        main(["canvas", "find", *(each.format(file=file, folder=tmp_path) for each in options)])
        == 2
    )
    (said,) = capsys.readouterr().err.strip().splitlines()
    assert says in said


def drawn(truth: Truth, dies_s: float = math.inf) -> Drawer:
    """Draw what two nodes report; the first one ends at a time."""
    layout, rectangles, _ = table(2)
    drawer = Drawer(layout)
    nodes = [
        SimulatedNode(f"node{i}", each, np.random.default_rng(i), CLOCKS)
        for i, each in enumerate(rectangles)
    ]
    assembler = wire.Assembler(0.3)
    for node in nodes:
        drawer.handle((node.name, "table"), [wire.Report("table", node.scene)])
    for each in in_order(nodes, truth):
        if each.node == "node0" and each.arrival_s > dies_s:
            continue
        events = assembler.receive_data(each.datagram, each.arrival_s)
        for event in received_events(events):
            assert isinstance(event, wire.TouchFrame | wire.Lost)
            now_us = START_US + round(each.arrival_s * 1e6)
            drawer.add((event.node, event.surface), event, now_us)
    return drawer


def test_the_fingers_of_a_node_that_dies_are_drawn_no_longer() -> None:
    held, other = (
        Finger(((0.5, x_mm, 60.0), (3.0, x_mm, 60.0)), ((0.6, 2.9),)) for x_mm in (60.0, 450.0)
    )
    drawer = drawn(Truth([held, other], 3.5), dies_s=1.5)
    lengths = {round(line[0][0][0] / 10.0): len(line) for line in drawer.picture._lines.values()}
    assert lengths[6] < 1.6 / 2.5 * lengths[45]


def test_a_pointer_keeps_its_colour_over_the_seam(tmp_path: Path) -> None:
    layout, _, (seam_mm,) = table(2)
    corners = ((0.5, 180.0, 100.0), (0.8, 180.0, 100.0), (1.6, 380.0, 100.0))
    drawer = drawn(Truth([Finger(corners, ((0.6, 1.5),))], 2.0))
    assert not drawer.absent()
    save(drawer.picture, tmp_path / "canvas.png")
    image = cv2.imread(str(tmp_path / "canvas.png"))
    assert image is not None
    px_per_mm = 1600 / (layout.width_mm + 40.0)
    columns = np.flatnonzero((image == colour(1)).all(axis=2).any(axis=0)) / px_per_mm - 20.0
    assert columns.min() < seam_mm - 80.0
    assert columns.max() > seam_mm + 70.0


def test_no_picture_is_written_where_no_frame_arrives(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], free_port: Callable[[], int]
) -> None:
    (layout := tmp_path / "layout.toml").write_text(
        'width_mm = 300.0\nheight_mm = 200.0\n[[surface]]\nnode = "left"\n'
    )
    out = tmp_path / "canvas.png"
    place = f"tcp/127.0.0.1:{free_port()}"
    options = ["draw", str(layout), "--out", str(out), "--seconds", "0.1", "--connect", place]
    assert main(["canvas", *options]) == 2
    assert "no frame of left/table arrived within 0.1 s" in capsys.readouterr().err
    assert not out.exists()
