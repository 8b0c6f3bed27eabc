"""Speed and errors of typing, against the definitions' own examples and properties."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from halo_type.metrics import Entry, distance, erased, typed, words_per_minute

WORDS = st.text("abc ", max_size=8)


def sequence(*texts, key_s=0.5):
    return [Entry(k * key_s, text) for k, text in enumerate(texts)]


def stroke_by_stroke(text, **more):
    return sequence(*(text[: k + 1] for k in range(len(text))), **more)


@pytest.mark.parametrize(
    "presented, transcribed, least",
    [
        ("", "", 0),
        ("abcd", "abcd", 0),
        ("abcd", "acbd", 2),  # no transpositions
        ("abcd", "", 4),
        ("", "ab", 2),
        ("quickly", "qucehkly", 3),  # MacKenzie and Soukoreff's example of an MSD
        ("kitten", "sitting", 3),
    ],
)
def test_the_distance_counts_the_fewest_changes(presented, transcribed, least):
    assert distance(presented, transcribed) == least
    assert distance(transcribed, presented) == least


@given(WORDS, WORDS, WORDS)
def test_the_distance_is_a_metric(a, b, c):
    assert (distance(a, b) == 0) == (a == b)
    assert distance(a, c) <= distance(a, b) + distance(b, c)
    assert abs(len(a) - len(b)) <= distance(a, b) <= max(len(a), len(b))


@pytest.mark.parametrize(
    "before, after, count",
    [
        ("ab", "abc", 0),
        ("abc", "ab", 1),
        ("abc", "", 3),
        ("ab", "axb", 0),  # put in the middle
        ("axb", "ab", 1),  # taken from the middle
        ("teh ", "the ", 2),  # replaced by an autocorrection
        ("aa", "aaa", 0),
        ("aaa", "aa", 1),
        ("cat", "dog", 3),
    ],
)
def test_what_neighbouring_texts_have_lost_was_erased(before, after, count):
    assert erased(before, after) == count


@given(WORDS, WORDS, WORDS)
def test_putting_text_in_anywhere_erases_nothing_and_taking_it_out_erases_it(head, more, tail):
    assert erased(head + tail, head + more + tail) == 0
    assert erased(head + more + tail, head + tail) == len(more)


CASES = {
    "without an error": ("the cat", stroke_by_stroke("the cat"), (7, 0, 0)),
    "a wrong letter left": ("the cat", stroke_by_stroke("the cst"), (6, 1, 0)),
    "a letter left out": ("the cat", stroke_by_stroke("the ct"), (6, 1, 0)),
    "a letter doubled": ("the cat", stroke_by_stroke("thee cat"), (7, 1, 0)),
    "a wrong letter corrected": ("cat", sequence("c", "cs", "c", "ca", "cat"), (3, 0, 1)),
    "a right letter erased and typed again": (
        "cat",
        sequence("c", "ca", "c", "ca", "cat"),
        (3, 0, 1),
    ),
    "a word replaced": ("the", sequence("t", "te", "teh", "the"), (3, 0, 2)),
    "one corrected, one left": ("cat", sequence("c", "cs", "c", "ca", "cay"), (2, 1, 1)),
    "nothing typed": ("cat", [], (0, 3, 0)),
}


@pytest.mark.parametrize("presented, entries, expected", CASES.values(), ids=CASES.keys())
def test_characters_are_right_left_wrong_or_erased(presented, entries, expected):
    found = typed(presented, entries)
    assert (found.correct, found.uncorrected, found.corrected) == expected
    whole = sum(expected)
    assert found.uncorrected_rate == pytest.approx(expected[1] / whole)
    assert found.corrected_rate == pytest.approx(expected[2] / whole)
    assert found.msd_rate == pytest.approx(expected[1] / (expected[0] + expected[1]))


def test_words_per_minute_leave_the_first_character_out():
    """21 characters, 20 of them in 10 s: 24 words of five a minute."""
    assert words_per_minute(stroke_by_stroke("x" * 21)) == pytest.approx(24.0)


def test_erasing_costs_time_but_adds_no_words():
    entries = sequence("c", "cs", "c", "ca", "cat")
    assert words_per_minute(entries) == pytest.approx((3 - 1) / 2.0 * 60 / 5)


@pytest.mark.parametrize(
    "entries",
    [[], sequence("a"), sequence("a", ""), sequence("a", "ab", key_s=0.0)],
    ids=["nothing", "one entry", "all erased", "no time passed"],
)
def test_no_text_or_no_time_is_no_speed(entries):
    assert words_per_minute(entries) == 0.0


def test_adjusted_speed_is_speed_times_accuracy():
    found = typed("abcde", stroke_by_stroke("abxde"))
    assert found.awpm == pytest.approx(found.wpm * 0.8)
