"""What a verification counts and draws."""

from __future__ import annotations

import numpy as np
import pytest

from halo_service.app.verification.crossings import REACH_MM, Finger, Grid

SIZE = (1280, 800)
PLAIN = np.array([[4.0, 0.0, 40.0], [0.0, 4.0, 0.0], [0.0, 0.0, 1.0]])
KEYSTONE = np.array([[4.0, 0.4, 20.0], [0.1, 3.6, 30.0], [0.0002, 0.0006, 1.0]])


def pixel(homography, place):
    x, y, w = homography @ (*place, 1.0)
    return x / w, y / w


def test_crossings_lie_evenly_within_the_surface() -> None:
    grid = Grid(300.0, 200.0, PLAIN, SIZE)
    assert len(grid.places) == 24
    assert grid.places.min(axis=0).tolist() == [30.0, 30.0]
    assert grid.places.max(axis=0).tolist() == [270.0, 170.0]
    assert len(Grid(60.0, 60.0, PLAIN, SIZE).places) == 4


@pytest.mark.parametrize(
    ("off_mm", "counted"), [((0.0, 0.0), True), ((3.0, -4.0), True), ((0.0, REACH_MM + 1), False)]
)
def test_a_touch_counts_for_the_crossing_next_to_it(off_mm, counted) -> None:
    grid = Grid(300.0, 200.0, PLAIN, SIZE)
    landing = grid.land(*(grid.places[7] + off_mm))
    assert (landing is not None) == counted
    if landing is not None:
        assert landing.crossing == 7
        assert (landing.dx_mm, landing.dy_mm) == pytest.approx(off_mm)
        assert landing.off_mm == pytest.approx(np.hypot(*off_mm))


def test_the_summary_names_the_worst_crossing() -> None:
    grid = Grid(300.0, 200.0, PLAIN, SIZE)
    assert grid.summary() is None
    for crossing, off in ((0, 1.0), (1, 2.0), (2, 9.0), (2, 5.0), (3, 1.0)):
        grid.land(*(grid.places[crossing] + (off, 0.0)))
    summary = grid.summary()
    assert summary is not None
    assert (summary.touches, summary.crossings, summary.worst) == (5, 4, 2)
    assert (summary.median_mm, summary.worst_mm) == pytest.approx((2.0, 7.0))
    assert summary.p95_mm == pytest.approx(8.2)
    assert "column 3" in grid.name(2)


def test_the_next_crossing_is_the_first_untouched_one() -> None:
    grid = Grid(100.0, 100.0, PLAIN, SIZE)
    for crossing in (0, 2, 1, 3):
        assert grid.next is not None
        grid.land(*grid.places[crossing])
    assert grid.next is None


def test_crossings_outside_the_picture_are_left_out() -> None:
    grid = Grid(300.0, 200.0, PLAIN, (700, 800))  # 165 of the 300 mm
    assert len(grid.places) == 12
    assert grid.places[:, 0].max() == 126.0
    assert "row 2 from the far edge, column 1" in grid.name(3)
    assert grid.pixel(3) == pytest.approx(pixel(PLAIN, grid.places[3]))


def test_a_crossing_that_is_given_up_is_asked_for_no_more() -> None:
    grid = Grid(100.0, 100.0, PLAIN, SIZE)
    grid.given_up.add(0)
    assert grid.next == 1


@pytest.mark.parametrize("homography", [PLAIN, KEYSTONE])
def test_lines_and_dots_are_drawn_where_the_homography_puts_them(homography) -> None:
    grid = Grid(300.0, 200.0, homography, SIZE)
    empty = grid.picture([])
    assert empty.shape == (SIZE[1], SIZE[0], 3)
    for place in grid.places:
        x, y = pixel(homography, place)
        assert empty[int(y), int(x)].max() > 40
    edges = [pixel(homography, edge) for edge in ((0.0, 100.0), (300.0, 100.0))]
    for x, y in edges:  # the surface's own, far from the grid
        assert empty[int(y) - 1 : int(y) + 2, int(x) - 1 : int(x) + 2].max() > 40
    finger = Finger(133.0, 88.0, True)
    dotted = grid.picture([finger])
    rows, columns = np.nonzero((dotted != empty).any(axis=2))
    middle = columns.mean() + 0.5, rows.mean() + 0.5
    assert middle == pytest.approx(pixel(homography, (133.0, 88.0)), abs=0.3)
