"""Surfaces are placed by touches that two nodes see, and by one marker."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

import halo_protocol as wire
from halo_service.canvas.finding.marker import MarkerError, between
from halo_service.canvas.finding.placing import Between, placed
from halo_service.canvas.finding.rigid import Places, fit, rigid
from halo_service.canvas.finding.touched import NodeTouches, Touched, pairs
from halo_service.canvas.layout import load, text

TRUE = rigid(math.radians(3.0), 258.0, -6.0)
SIZE = (300.0, 200.0)


def touches(count: int, noise_mm: float = 1.5, seed: int = 1) -> tuple[Places, Places]:
    """Places in the overlap of two surfaces, on each of them."""
    random = np.random.default_rng(seed)
    there = np.column_stack([random.uniform(2, 40, count), random.uniform(10, 190, count)])
    here = there @ TRUE[:2, :2].T + TRUE[:2, 2]
    return here + random.normal(0, noise_mm, here.shape), there


def test_six_touches_place_a_surface_within_what_the_fit_says() -> None:
    off = []
    for seed in range(100):
        found = fit(*touches(6, seed=seed))
        assert found is not None
        corner = np.array((0.0, 200.0, 1.0))
        off.append(math.dist((found.matrix @ corner)[:2], (TRUE @ corner)[:2]))
    (said,) = [fit(*touches(6, seed=3)).error_mm((0.0, 200.0))]  # type: ignore[union-attr]
    assert np.percentile(off, 95) < 4.0
    assert 0.3 < said < 3.0


def test_wrong_pairs_are_left_out() -> None:
    here, there = touches(8)
    here[2] += (40.0, 5.0)
    here[5] += (-12.0, 12.0)
    found = fit(here, there)
    assert found is not None
    assert [i for i, used in enumerate(found.used) if not used] == [2, 5]
    assert abs(found.angle_deg - 3.0) < 1.5
    assert found.off_mm < 3.0


@pytest.mark.parametrize("count", [0, 1, 2])
def test_fewer_than_three_touches_give_no_fit(count: int) -> None:
    assert fit(*touches(count)) is None


def test_touches_that_disagree_give_no_fit() -> None:
    random = np.random.default_rng(1)
    assert fit(random.uniform(0, 300, (4, 2)), random.uniform(0, 300, (4, 2))) is None


def test_touches_at_one_time_are_pairs_and_ambiguous_ones_are_not() -> None:
    one = [Touched(ms * 1000, (float(ms), 0.0)) for ms in (0, 1000, 2000, 2050, 3000)]
    other = [Touched(ms * 1000, (0.0, float(ms))) for ms in (30, 2010, 2990, 5000)]
    here, there = pairs(one, other)
    assert here.tolist() == [[0.0, 0.0], [3000.0, 0.0]]
    assert there.tolist() == [[0.0, 30.0], [0.0, 2990.0]]


def test_a_touch_is_the_median_place_while_it_lasts() -> None:
    node = NodeTouches()

    def receive(ms: int, x_mm: float, state: int, downs: tuple[wire.Down, ...] = ()) -> None:
        pointer = wire.Pointer(
            1, 0, 2, 1, state, 0.0, 0.0, x_mm, 50.0, 0.0, 0.5, 0.0, 0.0, 1.0, 1, -1.0
        )
        frame = wire.TouchFrame("table", "a", "s1", ms, ms * 1000, (pointer,), downs)
        node.receive(frame, ms * 1000 + 7000)

    for ms in range(0, 3000, 30):
        receive(ms, 10.0, 0)
    receive(3000, 90.0, 1, (wire.Down(1, 0, 0.0, 0.0, 100.0, 10.0, 1),))
    for ms in range(3030, 3300, 30):
        receive(ms, 100.0, 1)
    assert not node.touches
    receive(3300, 100.0, 0)
    receive(3330, 100.0, 1, (wire.Down(1, 0, 0.0, 0.0, 100.0, 0.0, 2),))
    for ms in range(3360, 3600, 30):
        receive(ms, 100.0 + (ms - 3330) / 10.0, 1)
    receive(3600, 120.0, 0)
    (touch,) = node.touches  # the second one was a drag
    assert touch.place_mm == (100.0, 50.0)
    assert abs(touch.time_us - 2_997_000) < 1000


def pose(anchor_from_surface: np.ndarray) -> wire.Pose:
    numbers = tuple(float(each) for each in anchor_from_surface[:3].ravel())
    return wire.Pose("a", "s1", 1, (0.0,) * 12, numbers)


def test_one_marker_places_two_surfaces() -> None:
    anchor_from_here = np.eye(4)
    anchor_from_here[:2, :2] = rigid(0.7, 0.0, 0.0)[:2, :2]
    anchor_from_here[:3, 3] = (-280.0, 40.0, 0.4)
    here_from_there = np.eye(4)
    here_from_there[:2, :2], here_from_there[:2, 3] = TRUE[:2, :2], TRUE[:2, 2]
    found = between(pose(anchor_from_here), pose(anchor_from_here @ here_from_there))
    assert np.allclose(found, TRUE)


def test_poses_of_two_markers_on_other_planes_are_refused() -> None:
    there = np.eye(4)
    there[2, 3] = 80.0
    with pytest.raises(MarkerError, match="80 mm in height"):
        between(pose(np.eye(4)), pose(there))


def test_a_chain_of_surfaces_becomes_a_layout_that_can_be_read(tmp_path: Path) -> None:
    a, b, c, d = ((name, "table") for name in ("a", "b", "c", "d"))
    step = rigid(0.0, 250.0, 0.0)
    known = [
        Between(a, b, step, 1.0),
        Between(c, b, np.linalg.inv(step), 1.0),
        Between(a, c, rigid(0.5, 0.0, 0.0), 9.0),
    ]
    layout, away = placed(dict.fromkeys((a, b, c, d), SIZE), known)
    assert away == [d]
    assert (layout.width_mm, layout.height_mm) == (800.0, 200.0)
    (file := tmp_path / "table.toml").write_text(text(layout))
    assert load(file) == layout
    assert [(each.node, each.x_mm) for each in layout.surface] == [
        ("a", 0.0), ("b", 250.0), ("c", 500.0),
    ]  # fmt: skip


def test_a_surface_to_the_left_moves_the_first_one() -> None:
    a, b = ("a", "table"), ("b", "table")
    layout, _ = placed({a: SIZE, b: SIZE}, [Between(a, b, rigid(math.pi, 40.0, 200.0), 1.0)])
    assert [(each.node, each.x_mm, each.y_mm) for each in layout.surface] == [
        ("a", 260.0, 0.0),
        ("b", 300.0, 200.0),
    ]
    assert layout.width_mm == 560.0
