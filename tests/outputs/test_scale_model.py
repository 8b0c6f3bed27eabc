"""The formulas of docs/scale.md give the bytes that the encoder writes."""

from __future__ import annotations

from dataclasses import replace

import pytest

import halo_protocol as wire
from benchmarks.scaling import model

POINTER = wire.Pointer(
    7, 0, 2, 1, 1, 0.5, 0.25, 150.0, 50.0, 0.0, 0.5, 0.0, 0.0, 0.9, 3, -1.0
)  # fmt: skip
DOWN = wire.Down(7, 0, 0.5, 0.25, 180.0, 12.0, 3)
UP = wire.Up(7, 0, 0.5, 0.25, 12.0, 3)
NAMES = [("n000", "s1", "table"), ("a", "s1234567", "x"), ("node-of-museum-3", "s1", "table-2")]


@pytest.mark.parametrize("names", NAMES)
@pytest.mark.parametrize(("pointers", "downs", "ups"), [(0, 0, 0), (1, 1, 0), (4, 1, 2), (7, 0, 0)])
def test_a_frame(names: tuple[str, str, str], pointers: int, downs: int, ups: int) -> None:
    node, session, surface = names
    header = wire.Frame(node, session, 1, 1, 1, pointers)
    written = wire.encode_frame(
        surface,
        header,
        [replace(POINTER, id=each) for each in range(pointers)],
        [DOWN] * downs,
        [UP] * ups,
    )
    assert [len(each) for each in written] == [model.frame_bytes(*names, pointers, downs, ups)]


@pytest.mark.parametrize("names", NAMES)
def test_the_reports(names: tuple[str, str, str]) -> None:
    node, session, surface = names
    versions = ("1.0.0", "0.1.0", "1.10.2")
    scene = wire.Scene(
        node, session, "1.0.0", 300.0, 200.0, 2, 1, 0, 30.0,
        service_version="0.1.0", zenoh_version="1.10.2",
    )  # fmt: skip
    messages: dict[wire.Message, int] = {
        scene: model.scene_bytes(*names, *versions),
        wire.Health(node, session, 30.0, 3.5, 0, 0, 3, 1): model.health_bytes(*names),
        wire.Homography(node, session, 1, 9, 9, (1.0,) * 9): model.homography_bytes(*names),
        wire.Pose(node, session, 1, (1.0,) * 12, (0.0,) * 12): model.pose_bytes(*names),
    }
    for message, predicted in messages.items():
        assert len(wire.encode(surface, message)) == predicted, type(message)


def test_the_stream_of_a_node_is_the_sum_of_what_it_sends() -> None:
    stream = model.plus(model.frames_of(2), model.reports_of(placed=True))
    names = ("n000", "s1", "table")
    reports = model.scene_bytes(*names, "1.0.0", "0.1.0", "1.10.2")
    placed = model.homography_bytes(*names) + model.pose_bytes(*names)
    assert stream.messages == 30 + 2 + 1 + 2 + 2
    assert stream.payload == (
        30 * model.frame_bytes(*names, 2) + 2 * reports + model.health_bytes(*names) + 2 * placed
    )


@pytest.mark.parametrize(
    ("surfaces", "routers", "leaf", "root"), [(10, 1, 690, None), (10_000, 101, 6900, 60_000)]
)
def test_a_tree_of_routers(surfaces: int, routers: int, leaf: int, root: int | None) -> None:
    """A leaf's 100 nodes: 33 messages in, 33 to a canvas, 3 to the root, which passes these on."""
    found = model.plan(surfaces)
    assert (found.routers, found.leaf.messages) == (routers, leaf)
    assert (found.root.messages if found.root else None) == root
