"""Where touches are reported. Each figure has a known answer."""

import numpy as np
import pytest

from halo_service.evaluation.metrics.spatial import (
    as_the_paper,
    ellipse,
    from_target,
    from_truth,
    spatial,
)
from halo_service.evaluation.metrics.touches import score_touches
from tests.evaluation.small_world import (
    contact,
    down,
    published_frames,
    truth_frames,
    truth_of,
)


def hits_at(offsets):
    """One touch a frame at its target, reported off by so much."""
    lines, downs = [], {}
    for k, (dx, dy) in enumerate(offsets):
        frame = 10 * k + 5
        lines.append(contact(frame - 0.5, frame + 3, target_mm=[102.0, 100.0]))
        downs[frame] = [down(x_mm=100.0 + dx, y_mm=100.0 + dy)]
    count = 10 * len(offsets) + 10
    return score_touches(
        published_frames(count, downs), truth_of([*truth_frames(count), *lines])
    ).hits


def test_spatial_error_is_from_the_true_place_with_nothing_removed():
    off = spatial(from_truth(hits_at([(3.0, 4.0), (3.0, 4.0), (0.0, 4.0), (6.0, 4.0)])))
    assert off.bias_mm == pytest.approx((3.0, 4.0))
    assert off.mean_mm == pytest.approx((5.0 + 5.0 + 4.0 + 52**0.5) / 4)


def test_the_papers_reduction_removes_the_common_offset_and_the_outliers():
    errors = from_target(hits_at([(9.0, 1.0), (9.0, -1.0), (10.0, 0.0), (8.0, 0.0)] * 5))
    assert spatial(errors).bias_mm == pytest.approx((7.0, 0.0))
    assert spatial(as_the_paper(errors)).mean_mm == pytest.approx(1.0)
    far = np.vstack([errors, [[60.0, 0.0]]])
    assert len(as_the_paper(far)) == len(errors)


def test_the_ellipse_holds_95_percent_of_a_normal_cloud():
    rng = np.random.default_rng(5)
    turn = np.radians(30.0)
    axes = np.array([[np.cos(turn), np.sin(turn)], [-np.sin(turn), np.cos(turn)]])
    cloud = rng.normal(0.0, (4.0, 1.5), (20_000, 2)) @ axes + (7.0, -2.0)
    found = ellipse(cloud)
    assert (found.x_mm, found.y_mm) == pytest.approx((7.0, -2.0), abs=0.1)
    assert found.angle_deg == pytest.approx(30.0, abs=1.0)
    along = (cloud - (found.x_mm, found.y_mm)) @ axes.T / (found.major_mm, found.minor_mm)
    assert np.mean(np.hypot(*along.T) <= 1.0) == pytest.approx(0.95, abs=0.01)


def test_no_touch_has_no_spatial_error_and_one_has_no_spread():
    assert spatial(from_truth(())) is None
    assert spatial(from_truth(hits_at([(3.0, 4.0)]))).ellipse.major_mm == 0.0
