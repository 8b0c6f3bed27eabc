"""Surfaces that are placed wrongly are reported."""

from __future__ import annotations

import pytest

from halo_service.canvas.detections import Area
from halo_service.canvas.layout import Layout, PlacedSurface
from halo_service.canvas.placement import overlap_mm, placement_warnings


def area(node: str, x_mm: float, y_mm: float = 0.0, angle_deg: float = 0.0) -> Area:
    placed = Area(PlacedSurface(node, "table", x_mm, y_mm, angle_deg))
    placed.size_mm = (300.0, 200.0)
    return placed


@pytest.mark.parametrize(
    ("other", "expected_mm"),
    [
        (area("b", 260.0), 40.0),
        (area("b", 1500.0), -1200.0),
        (area("b", 0.0, 140.0), 60.0),
        (area("b", 540.0, 200.0, 180.0), 60.0),  # it covers 240 to 540 mm
        (area("b", 480.0, 0.0, 90.0), 20.0),  # it covers 280 to 480 mm
        (area("b", 310.0, 205.0, 45.0), -10.6),  # (10 + 5) / sqrt(2) past the corner
    ],
)
def test_the_overlap_is_the_width_of_the_strip_that_both_see(
    other: Area, expected_mm: float
) -> None:
    found_mm = overlap_mm(area("a", 0.0), other)
    assert found_mm == pytest.approx(expected_mm, abs=0.1)
    assert overlap_mm(other, area("a", 0.0)) == pytest.approx(found_mm)


@pytest.mark.parametrize(
    ("x_mm", "width_mm", "says"),
    [
        (240.0, 540.0, []),
        (280.0, 580.0, ["a/table overlaps by 20 mm only", "b/table overlaps by 20 mm only"]),
        (
            1500.0,
            540.0,
            [
                "a/table overlaps with no other surface",
                "b/table overlaps with no other surface",
                "b/table reaches 1260 mm beyond the canvas",
            ],
        ),
    ],
)
def test_a_gap_and_a_surface_beyond_the_canvas_are_named(
    x_mm: float, width_mm: float, says: list[str]
) -> None:
    areas = [area("a", 0.0), area("b", x_mm)]
    found = list(placement_warnings(Layout(width_mm, 200.0), areas))
    assert [
        text for text, start in zip(found, says, strict=True) if text.startswith(start)
    ] == found


def test_one_surface_alone_needs_no_overlap() -> None:
    assert not list(placement_warnings(Layout(300.0, 200.0), [area("a", 0.0)]))
