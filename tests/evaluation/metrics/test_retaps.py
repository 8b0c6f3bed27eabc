"""The touch point threshold. Each figure has a known answer."""

from math import inf, isnan

import pytest

from halo_service.evaluation.metrics.retaps import (
    Retap,
    score_retaps,
    threshold_mm,
)
from halo_service.evaluation.metrics.touches import score_touches
from tests.evaluation.small_world import (
    COUNT,
    contact,
    down,
    published_frames,
    truth_frames,
    truth_of,
)


def test_retaps_are_those_that_the_script_names():
    lines = [contact(5, 8), contact(12, 15), contact(20, 23)]
    truth = truth_of([*truth_frames(COUNT), *lines])
    touches = score_touches(published_frames(COUNT, {5: [down()], 20: [down()]}), truth)
    script = [
        {"step": "retap", "from_s": 9 / 30, "to_s": 15 / 30, "lift_mm": 0.5},
        {"step": "retap", "from_s": 16 / 30, "to_s": 23 / 30, "lift_mm": 4.0},
    ]
    assert score_retaps(touches, truth, script) == (Retap(0.5, False), Retap(4.0, True))


@pytest.mark.parametrize(
    "reported, threshold",
    [
        ({1.0: 100, 2.0: 100, 3.0: 100}, 1.0),
        ({1.0: 50, 2.0: 99, 3.0: 100}, 2.0),
        ({1.0: 100, 2.0: 98, 3.0: 100}, 3.0),
        ({1.0: 100, 2.0: 100, 3.0: 98}, inf),
    ],
    ids=["every lift", "from 2 mm on", "a gap counts against what is below", "none"],
)
def test_the_threshold_is_the_least_lift_from_which_on_nearly_all_are_reported(reported, threshold):
    retaps = [Retap(lift, k < count) for lift, count in reported.items() for k in range(100)]
    assert threshold_mm(retaps) == threshold


def test_without_retaps_there_is_no_threshold():
    assert isnan(threshold_mm([]))
