"""A session under a real camera: reports are compared with the script, without any truth."""

import pytest

from halo_service.evaluation.metrics.scripted import score_script
from halo_service.values import Touch
from tests.evaluation.small_world import SURFACE, down, pointer, published_frames, up


def target(begin, end, x_mm=100.0, y_mm=100.0):
    return {"step": "target", "from_s": begin, "to_s": end, "target_mm": [x_mm, y_mm]}


CASES = {
    "touched once": ({20: [down()]}, (1, 0, 0, 0)),
    "not touched": ({}, (0, 1, 0, 0)),
    "reported twice": ({20: [down()], 30: [down()]}, (1, 0, 1, 0)),
    "reported elsewhere": ({20: [down(x_mm=140.0)]}, (0, 1, 0, 1)),
    "reported before the step": ({5: [down()]}, (0, 1, 0, 0)),
}


@pytest.mark.parametrize("downs, counts", CASES.values(), ids=CASES.keys())
def test_each_target_is_touched_once_during_its_step(downs, counts):
    touches = score_script(published_frames(60, downs), [target(0.5, 1.5)], SURFACE).touches
    found = touches.hits, touches.missed, touches.doubled, touches.outside
    assert tuple(map(len, found)) == counts


def test_place_is_measured_from_the_target_and_time_not_at_all():
    events = {20: [down(x_mm=103.0, y_mm=104.0)], 25: [up()]}
    scores = score_script(published_frames(60, events), [target(0.5, 1.5)], SURFACE)
    (hit,) = scores.touches.hits
    assert hit.true_mm == pytest.approx((100.0, 100.0))
    assert (scores.timing, scores.strikes, scores.velocities) == ((), (), ())


@pytest.mark.parametrize(
    "step, reported, error",
    [
        ({"step": "hover", "height_mm": 10.0}, {"hover_mm": 12.5}, 2.5),
        (
            {"step": "pressure", "force_g": 96.25},
            {"state": Touch.TOUCH, "hover_mm": 0.0, "force_g": 96.25 - 38.5},
            10.0,
        ),
    ],
    ids=["hover", "pressure"],
)
def test_levels_are_compared_with_the_spacer_or_scale(step, reported, error):
    script = step | {"from_s": 0.5, "to_s": 1.5}
    pointers = {k: [pointer(2, hover_mm=80.0), pointer(1, 60.0, **reported)] for k in range(60)}
    (trial,) = score_script(published_frames(60, pointers=pointers), [script], SURFACE).trials
    assert (trial.error, trial.no_reading) == pytest.approx((error, 0.0))


def test_a_level_without_a_pointer_has_no_reading():
    script = {"step": "hover", "height_mm": 10.0, "from_s": 0.5, "to_s": 1.5}
    pointers = {k: [] for k in range(60)}
    (trial,) = score_script(published_frames(60, pointers=pointers), [script], SURFACE).trials
    assert trial.no_reading == 1.0


def test_without_frames_there_are_no_scores():
    assert score_script((), [target(0.0, 1.0)], SURFACE).touches.true == 0
