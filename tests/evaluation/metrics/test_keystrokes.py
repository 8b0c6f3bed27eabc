"""Keys and text. Each figure has a known answer."""

import pytest

from halo_service.evaluation.metrics.keystrokes import score_keys, score_phrases
from halo_service.evaluation.metrics.touches import score_touches
from halo_service.virtual.scenarios.typing import keys
from tests.evaluation.small_world import (
    FRAME_US,
    contact,
    down,
    published_frames,
    truth_frames,
    truth_of,
)


def typed_touches(text, reported, again=(), aside_mm=0.0):
    """Type a text; `reported`: what of each stroke is published, mm next to it or None.

    `again`: mm next to the key at which some strokes are reported once more, by their number;
    `aside_mm`: how far from the middle of their keys the fingers land.
    """
    layout, lines, downs = keys(), [], {}
    for k, (character, off) in enumerate(zip(text, reported, strict=True)):
        x, y = layout[character].middle
        landed = x + aside_mm, y
        lines.append(contact(15 * k + 5, 15 * k + 8, *landed, key=character, target_mm=[x, y]))
        if off is not None:
            downs[15 * k + 5] = [down(x_mm=x + off, y_mm=y)]
        if k in dict(again):
            downs[15 * k + 7] = [down(x_mm=x + dict(again)[k], y_mm=y)]
    count = 15 * len(text) + 10
    return score_touches(published_frames(count, downs), truth_of([*truth_frames(count), *lines]))


def test_keys_are_wrong_where_another_was_reported():
    touches = typed_touches("table", [0.0, 5.0, 12.0, None, -3.0])
    counted = score_keys(touches)
    assert (counted.struck, counted.wrong, counted.missed) == (5, 1, 1)


@pytest.mark.parametrize(
    "again, aside_mm, doubled",
    [
        ({}, 0.0, 0),
        ({0: 0.0}, 0.0, 1),
        ({0: 0.0, 2: 16.0}, 0.0, 2),
        ({0: -24.0}, 0.0, 0),
        ({0: 0.0}, 7.0, 0),
    ],
    ids=[
        "each once",
        "one twice",
        "one as its neighbour, too",
        "next to the keyboard",
        "landed at the key's edge",
    ],
)
def test_keys_are_doubled_where_the_finger_landed_well_inside(again, aside_mm, doubled):
    touches = typed_touches("qaz", [0.0] * 3, tuple(again.items()), aside_mm)
    assert len(touches.doubled) == len(again)
    assert score_keys(touches).doubled == doubled


def test_a_doubled_down_counts_for_the_stroke_that_it_is_nearest_to():
    """Two fingers at once: one well inside `q`, the other at the edge of `w` and reported twice."""
    layout = keys()
    (qx, y), (wx, _) = layout["q"].middle, layout["w"].middle
    lines = [
        contact(5, 9, qx, y, key="q", target_mm=[qx, y]),
        contact(5, 9, wx + 7.0, y, key="w", target_mm=[wx, y], hand="left"),
    ]
    downs = {5: [down(1, qx, y), down(2, wx, y)], 7: [down(3, wx + 3.0, y)]}
    touches = score_touches(published_frames(15, downs), truth_of([*truth_frames(15), *lines]))
    counted = score_keys(touches)
    assert len(touches.doubled) == 1
    assert (counted.struck, counted.doubled) == (1, 0)


def test_the_text_consists_of_the_reported_keys():
    (phrase,) = score_phrases(typed_touches("table", [0.0, 0.0, 16.0, None, 0.0]))
    assert phrase.presented == "table"
    assert (phrase.typed.correct, phrase.typed.uncorrected) == (3, 2)  # "tane"
    assert phrase.perfect.uncorrected == 0
    assert phrase.perfect.wpm == pytest.approx(60 / 5 / (15 * FRAME_US / 1e6), rel=1e-4)
