"""Touches: every true one is scored once, and every published one is counted."""

import itertools

import pytest

from halo_service.evaluation.metrics.pool import pool
from halo_service.evaluation.metrics.timing import score_timing
from halo_service.evaluation.metrics.touches import Touches, score_touches
from halo_service.evaluation.metrics.truth import BEYOND_MM, read_truth
from halo_service.sensing import SensingSettings
from tests.evaluation.small_world import (
    SURFACE,
    at,
    contact,
    down,
    finger,
    published_frames,
    truth_frames,
    up,
)

LONG = 40
KINDS = ("hits", "missed", "doubled", "outside", "ghosts", "between_frames")


def scored(contacts, downs, frames=LONG):
    truth = read_truth([*truth_frames(frames), *contacts], SURFACE)
    return score_touches(published_frames(frames, downs), truth)


def counts(touches):
    return {kind: len(getattr(touches, kind)) for kind in KINDS if len(getattr(touches, kind))}


CASES = {
    "reported in the first frame of contact": ([contact(4.5, 9)], {5: [down()]}, {"hits": 1}),
    "reported two frames late": ([contact(4.5, 9)], {7: [down()]}, {"hits": 1}),
    "reported just after it ended": ([contact(4.5, 6.5)], {8: [down()]}, {"hits": 1}),
    "reported a frame early": ([contact(6.0, 9)], {5: [down()]}, {"hits": 1}),
    "reported far too early": ([contact(9.0, 12)], {5: [down()]}, {"missed": 1, "ghosts": 1}),
    "reported long after it ended": (
        [contact(4.5, 6.5)],
        {11: [down()]},
        {"missed": 1, "ghosts": 1},
    ),
    "never reported": ([contact(4.5, 9)], {}, {"missed": 1}),
    "reported twice": ([contact(4.5, 12)], {5: [down()], 9: [down()]}, {"hits": 1, "doubled": 1}),
    "reported thrice": (
        [contact(4.5, 15)],
        {5: [down()], 9: [down()], 12: [down()]},
        {"hits": 1, "doubled": 2},
    ),
    "reported 24 mm off": ([contact(4.5, 9)], {5: [down(x_mm=124.0)]}, {"hits": 1}),
    "reported 26 mm off": ([contact(4.5, 9)], {5: [down(x_mm=126.0)]}, {"missed": 1, "outside": 1}),
    "reported near the finger, far from the target": (
        [contact(4.5, 9, target_mm=[130.0, 100.0])],
        {5: [down()]},
        {"missed": 1, "outside": 1},
    ),
    "never reported, 19 mm outside the surface": ([contact(4.5, 9, -19.0)], {}, {"missed": 1}),
    "never reported, beyond its margin": (
        [contact(4.5, 9, 285.0, 219.0, target_mm=[321.0, 100.0])],
        {},
        {},
    ),
    "reported beyond the margin": ([contact(4.5, 9, 100.0, 222.0)], {5: [down(y_mm=222.0)]}, {}),
    "reported while nothing touched": ([], {5: [down()]}, {"ghosts": 1}),
    "two that follow closely, each reported": (
        [contact(4.5, 6.5), contact(8.5, 11)],
        {7: [down()], 9: [down()]},
        {"hits": 2},
    ),
    "two that follow closely, reported as one": (
        [contact(4.5, 6.5), contact(8.5, 11)],
        {5: [down()]},
        {"hits": 1, "missed": 1},
    ),
    "two fingers at once, one reported": (
        [contact(4.5, 9), contact(4.5, 9, 200.0, finger="middle")],
        {5: [down(2, 200.0)]},
        {"hits": 1, "missed": 1},
    ),
    "between two frames, reported": (
        [contact(4.3, 4.6)],
        {5: [down()]},
        {"between_frames": 1},
    ),
    "between two frames, not reported": ([contact(4.3, 4.6)], {}, {"between_frames": 1}),
}


@pytest.mark.parametrize("contacts, downs, expected", CASES.values(), ids=CASES.keys())
def test_every_touch_is_scored_once(contacts, downs, expected):
    assert counts(scored(contacts, downs)) == expected


def test_touches_are_paired_so_that_as_many_as_can_be_are_hit():
    """A late down of the first and an early one of the second lie near the same touch."""
    contacts = [contact(4.0, 5.0), contact(7.0, 10.0)]
    touches = scored(contacts, {6: [down()], 7: [down()]})
    assert counts(touches) == {"hits": 2}
    assert [(h.touch.from_us, h.down.time_us) for h in touches.hits] == [
        (at(4.0), at(6)),
        (at(7.0), at(7)),
    ]


def test_a_touch_that_the_end_cuts_off_is_neither_hit_nor_missed():
    pressed = {k: [finger(height_mm=0.0)] for k in range(7, 10)}
    truth = read_truth(truth_frames(10, pressed), SURFACE)
    assert [touch.ended for touch in truth.touches] == [False]
    for downs in ({}, {8: [down()]}):
        assert counts(score_touches(published_frames(10, downs), truth)) == {}


def test_a_touch_between_frames_is_counted_separately_and_costs_no_precision():
    touches = scored([contact(4.3, 4.6), contact(10, 14)], {5: [down()], 10: [down()]})
    assert (touches.true, touches.between_frames_hits, touches.precision) == (1, 1, 1.0)


def test_the_papers_own_counts_give_the_papers_own_shares():
    """3840 touches, 13 missed, 45 doubled: 98.8, 99.7 and 99.2 % (5.3.1)."""
    one = scored([contact(4.5, 9)], {5: [down()]})
    two = scored([contact(4.5, 12)], {5: [down()], 9: [down()]})
    none = scored([contact(4.5, 9)], {})
    all_ = pool(Touches, [one] * (3840 - 13 - 45) + [two] * 45 + [none] * 13)
    assert all_.true == 3840
    assert (round(all_.precision, 3), round(all_.recall, 3), round(all_.f1, 3)) == (
        0.988, 0.997, 0.992,
    )  # fmt: skip


def test_no_report_without_touches_is_no_error():
    assert (Touches().precision, Touches().recall, Touches().f1) == (1.0, 1.0, 1.0)


def test_a_touch_is_timed_by_the_frame_that_reported_it():
    downs = {7: [down(ago_ms=60.0)], 12: [up(ago_ms=50.0)]}
    (timing,) = score_timing(scored([contact(4.5, 10.0)], downs).hits)
    assert timing.frames_late == 2  # frame 5 was the first in contact
    assert timing.down_ms == pytest.approx(2.5 * 33.333, abs=0.01)
    assert timing.down_ago_error_ms == pytest.approx(2.5 * 33.333 - 60.0, abs=0.01)
    assert timing.up_ms == pytest.approx(2 * 33.333, abs=0.01)
    assert timing.up_ago_error_ms == pytest.approx(2 * 33.333 - 50.0, abs=0.01)


def test_a_touch_that_never_ends_has_no_end_to_time():
    (timing,) = score_timing(scored([contact(4.5, 9)], {5: [down()]}).hits)
    assert timing.up_ms is None


@pytest.mark.parametrize("order", list(itertools.permutations(range(3))))
def test_lines_of_truth_may_come_in_any_order(order):
    lines = [*truth_frames(2), contact(0.5, 1.0)]
    truth = read_truth([lines[k] for k in order], SURFACE)
    assert [frame.time_us for frame in truth.frames] == [at(0), at(1)]
    assert truth.touches[0].frames == 1


def test_no_touch_counts_where_the_service_reports_none():
    assert SensingSettings().edge_margin_mm == BEYOND_MM
