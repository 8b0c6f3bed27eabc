"""Confidence: a wrong touch should have a low one; and touches that are difficult to see."""

import math
import pickle

import pytest

from halo_service.evaluation.metrics.confidence import Confidence, reliability, score_confidence
from halo_service.evaluation.metrics.difficult import score_difficult
from halo_service.evaluation.metrics.pool import pool
from halo_service.evaluation.metrics.scores import Scores
from halo_service.evaluation.metrics.touches import published, score_touches
from halo_service.evaluation.metrics.truth import read_truth
from halo_service.evaluation.report.figures import by_difficulty
from tests.evaluation.small_world import (
    SURFACE,
    contact,
    down,
    pointer,
    published_frames,
    truth_frames,
)

FRAMES = 60
AIMED = {"target_mm": [110.0, 100.0]}


def scored(contacts, downs, confidences):
    """Pair touches with downs; `confidences`: of the pointer in a frame, None: it has none."""
    truth = read_truth([*truth_frames(FRAMES), *contacts], SURFACE)
    pointers = {k: [] if c is None else [pointer(confidence=c)] for k, c in confidences.items()}
    return score_touches(published_frames(FRAMES, downs, pointers), truth), truth


TOUCH = [contact(4.5, 12)]
CASES = {
    "right, just high": (TOUCH, {5: [down()]}, {5: 0.75}, Confidence(right_high=1)),
    "right, low": (TOUCH, {5: [down()]}, {5: 0.74}, Confidence(right_low=1)),
    "right, without confidence": (TOUCH, {5: [down()]}, {5: None}, Confidence(right_high=1)),
    "low in other frames": (TOUCH, {5: [down()]}, {4: 0.1, 6: 0.1}, Confidence(1)),
    "8 mm off": (TOUCH, {5: [down(x_mm=108.0)]}, {}, Confidence(right_high=1)),
    "farther off": (TOUCH, {5: [down(x_mm=108.1)]}, {}, Confidence(wrong_high=1)),
    "farther off, low": (
        TOUCH, {5: [down(x_mm=108.1)]}, {5: 0.5}, Confidence(wrong_low=1)),
    "where the finger was, not where it aimed": (
        [contact(4.5, 12, **AIMED)], {5: [down()]}, {}, Confidence(right_high=1)),
    "twice, the second low": (
        TOUCH, {5: [down()], 9: [down()]}, {9: 0.5}, Confidence(1, 0, 0, 1)),
    "outside": (TOUCH, {5: [down(x_mm=126.0)]}, {}, Confidence(wrong_high=1)),
    "of nothing, low": ([], {5: [down()]}, {5: 0.7}, Confidence(wrong_low=1)),
    "of nothing, without confidence": ([], {5: [down()]}, {5: None}, Confidence(wrong_high=1)),
    "not reported": (TOUCH, {}, {}, Confidence()),
}  # fmt: skip


@pytest.mark.parametrize("contacts, downs, confidences, expected", CASES.values(), ids=CASES.keys())
def test_a_down_is_right_or_wrong_with_high_or_low_confidence(
    contacts, downs, confidences, expected
):
    touches, _ = scored(contacts, downs, confidences)
    assert score_confidence(touches) == expected


def test_reliability_counts_the_right_touches_in_each_bin_of_confidence():
    contacts = [contact(4.5 + 10 * n, 9 + 10 * n) for n in range(4)]
    downs = {5 + 10 * n: [down()] for n in range(4)} | {49: [down()], 55: [down()]}
    confidences = {5: 0.95, 15: 0.9, 25: 0.55, 35: None, 49: 1.0, 55: 0.5}  # the last are ghosts
    touches, _ = scored(contacts, downs, confidences)
    bins = {each.least: each for each in reliability(touches) if each.reported}
    assert {least: (b.right, b.reported) for least, b in bins.items()} == {0.9: (2, 3), 0.5: (1, 2)}
    assert bins[0.9].confidence == pytest.approx(0.95)
    assert bins[0.5].share == 0.5


def test_recordings_add_up():
    both = pool(Confidence, [Confidence(1, 2, 3, 4), Confidence(10, 20, 30, 40)])
    assert (both, both.right, both.reported) == (Confidence(11, 22, 33, 44), 33, 110)


def test_a_down_without_a_pointer_stays_the_same_between_processes():
    (one,) = published(published_frames(9, {5: [down()]}, {5: []}))
    assert math.isnan(one.confidence)
    assert pickle.loads(pickle.dumps(one)) == one


def step(begin, end, **fields):
    name = "angle" if "pitch_deg" in fields else "edge"
    return {"step": name, "from_s": begin / 30, "to_s": end / 30} | fields


SCRIPT = [step(0, 20, pitch_deg=8.0), step(20, 40, beyond_mm=-4.0), step(40, 60, pitch_deg=8.0)]


def awkward(contacts, downs, script=SCRIPT):
    touches, truth = scored(contacts, downs, {})
    return score_difficult(touches, truth, script)


def test_each_touch_has_what_else_was_reported_since_its_feint():
    contacts = [contact(begin, begin + 5) for begin in (11.5, 31.5, 51.5)]
    downs = {5: [down()], 12: [down()], 15: [down()], 21: [down()], 52: [down(x_mm=103.0)]}
    pairs = awkward(contacts, downs)
    assert [(pair.kind, pair.value) for pair in pairs] == [
        ("angle", 8.0), ("edge", -4.0), ("angle", 8.0),
    ]  # fmt: skip
    found = [
        (len(t.hits), len(t.missed), len(t.doubled), len(t.ghosts))
        for t in (pair.touches for pair in pairs)
    ]
    assert found == [(1, 0, 1, 1), (0, 1, 0, 1), (1, 0, 0, 0)]
    flat = by_difficulty(Scores(difficult=pairs))["angle", 8.0].touches
    assert (len(flat.hits), len(flat.ghosts)) == (2, 1)
    assert [hit.off_mm for hit in flat.hits] == pytest.approx([0.0, 3.0])


def test_reports_between_the_steps_are_ignored():
    contacts, late = [contact(11.5, 15)], step(8, 20, pitch_deg=8.0)
    (pair,) = awkward(contacts, {5: [down()], 12: [down()], 25: [down()]}, [late])
    assert (len(pair.touches.hits), pair.touches.ghosts) == (1, ())


@pytest.mark.parametrize("other", [step(0, 20, lift_mm=2.0), {"step": "angle"}, {"step": "retap"}])
def test_other_steps_are_ignored(other):
    other = {"from_s": 0.0, "to_s": 1.0} | other
    assert awkward([contact(11.5, 15)], {12: [down()]}, [other]) == ()


def test_a_step_without_its_touch_is_left_out():
    assert awkward([], {5: [down()]}) == ()
