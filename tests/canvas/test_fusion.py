"""Fingers that nodes lose for a moment and find again far away: fast hands move 40 mm a frame."""

from __future__ import annotations

import pytest

import halo_protocol as wire
from halo_service.canvas.detections import Area, SurfaceKey
from halo_service.canvas.fusion import Fusion, NodeFrame
from halo_service.canvas.layout import PlacedSurface
from halo_service.values import Pointer

LEFT, RIGHT = ("left", "table"), ("right", "table")
FRAME_US = 33_333


class Table:
    """Two surfaces, of which the right one begins at x = 240 mm."""

    def __init__(self) -> None:
        placed = (PlacedSurface("left"), PlacedSurface("right", x_mm=240.0))
        areas = {area.surface: area for area in map(Area, placed)}
        for area in areas.values():
            area.size_mm = (300.0, 200.0)
        self.areas, self.fusion, self.time_us = areas, Fusion(areas), 0

    def sees(self, surface: SurfaceKey, *seen: wire.Pointer) -> tuple[Pointer, ...]:
        """Let a node send a frame; return what is on the canvas then."""
        self.time_us += FRAME_US
        pointers = tuple(self.areas[surface].detection(each, self.time_us) for each in seen)
        self.fusion.receive(NodeFrame(surface, self.time_us, pointers))
        return self.fusion.frame(self.time_us)[0]


def finger(x_mm: float, confidence: float, *, id: int = 7, hand: int = 2) -> wire.Pointer:  # noqa: A002
    """A hovering index finger on its node's surface."""
    return wire.Pointer(
        id, 0, hand, 1, 0, x_mm / 300.0, 0.5, x_mm, 100.0, 10.0, 0.0, 0.0, 0.0, confidence, 0, -1.0
    )  # fmt: skip


@pytest.fixture
def table() -> Table:
    """Two frames in which the left node sees a right index finger at 180 mm, and one without."""
    table = Table()
    for confidence in (0.9, 0.9, 0.1):
        (seen,) = table.sees(LEFT, finger(180.0, confidence))
    assert seen.id == 1
    return table


@pytest.mark.parametrize(
    ("surface", "x_mm", "hand", "keeps"),
    [
        (LEFT, 280.0, 2, True),
        (RIGHT, 50.0, 2, True),
        (LEFT, 280.0, 1, False),
        (RIGHT, 50.0, 1, False),
        (RIGHT, 290.0, 2, False),
    ],
    ids=["same node", "another node", "other hand", "another node, other hand", "too far"],
)
def test_a_lost_finger_is_found_again_by_its_name(
    table: Table, surface: SurfaceKey, x_mm: float, hand: int, keeps: bool
) -> None:
    lost = (finger(180.0, 0.05),) if surface == LEFT else ()
    seen = table.sees(surface, *lost, finger(x_mm, 0.9, id=8, hand=hand))
    assert {each.id for each in seen} == ({1} if keeps else {1, 2})


def test_a_finger_that_is_seen_well_stays_where_it_is() -> None:
    table = Table()
    for _ in range(2):
        table.sees(LEFT, finger(180.0, 0.9))
    seen = table.sees(RIGHT, finger(50.0, 0.9, id=8))
    assert {(each.id, round(each.x_mm)) for each in seen} == {(1, 180), (2, 290)}


def test_the_fingers_of_two_people_stay_two_while_one_is_seen_badly() -> None:
    table = Table()
    for _ in range(30):
        table.sees(LEFT, finger(60.0, 0.9), finger(200.0, 0.9, id=8))
    for _ in range(4):
        seen = table.sees(LEFT, finger(60.0, 0.1), finger(200.0, 0.9, id=8))
        assert [(each.id, round(each.x_mm)) for each in seen] == [(1, 60), (2, 200)]


def test_what_remains_of_a_finger_at_its_old_place_is_no_second_finger(table: Table) -> None:
    for confidence in (0.3, 0.2, 0.1):
        seen = table.sees(LEFT, finger(20.0, confidence), finger(120.0, 0.9, id=8))
    assert [each.id for each in seen] == [1]


def test_a_weak_pointer_does_not_replace_a_weak_one_that_is_seen_better() -> None:
    table = Table()
    for confidence in (0.9, 0.9, 0.35):
        table.sees(LEFT, finger(180.0, confidence))
    table.sees(LEFT, finger(180.0, 0.3), finger(190.0, 0.2, id=8))
    (seen,) = table.sees(LEFT, finger(230.0, 0.9))
    assert seen.id == 1
