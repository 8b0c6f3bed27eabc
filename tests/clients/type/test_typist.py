"""From frames to text and results, written by hand: each figure was computed by hand."""

import csv
import io

import pytest

from halo_type.layout import DELETE, DONE, SPACE, load_layout
from halo_type.results import COLUMNS, MEAN, summary, to_csv, write_results
from halo_type.typist import Trial, Typist

QWERTY = load_layout("qwerty")
FRAMES_A_KEY = 15


class Hands:
    """Types keys, one each half second."""

    def __init__(self, wire, typist):
        self.wire, self.typist, self.number, self.contacts = wire, typist, 0, 0

    def strike(self, *characters, off_mm=(0.0, 0.0), pause_s=0.0):
        """Touch the middle of keys, or a place next to it."""
        self.number += round(30 * pause_s)
        struck = []
        for character in characters:
            x, y = self.typist.shown.keys[character].middle
            at = x + off_mm[0], y + off_mm[1]
            self.contacts += 1
            down = self.wire.down(at=at, ago_ms=0.0, contacts=self.contacts)
            finger = self.wire.finger(at=at, pressure=0.5, contacts=self.contacts)
            struck += self.typist.process(self.wire.frame(self.number, [finger], downs=(down,)))
            self.typist.process(self.wire.frame(self.number + 1, [finger]))
            self.number += FRAMES_A_KEY
        return struck

    def type(self, text):
        return self.strike(*text)


def session(wire, *presented, **options):
    typist = Typist(
        QWERTY, [Trial("t", n + 1, each) for n, each in enumerate(presented)], **options
    )
    return typist, Hands(wire, typist)


def test_each_touch_types_one_key_and_done_ends_the_phrase(wire):
    typist, hands = session(wire, "the cat", "a dog")
    hands.type("the cat")
    assert typist.shown.text == "the cat" and not typist.results
    hands.strike(DONE)
    assert typist.shown.text == "" and typist.shown.trial.number == 2
    (result,) = typist.results
    assert result.transcribed == "the cat"
    assert result.seconds == pytest.approx(3.0, abs=1e-3)
    assert result.typed.wpm == pytest.approx(6 / 3.0 * 12, rel=1e-3)


def test_delete_erases_the_last_character_and_counts_as_corrected(wire):
    typist, hands = session(wire, "cat")
    hands.strike(DELETE, "c", "s", DELETE, "a", "t", DONE)
    assert typist.results[0].transcribed == "cat"
    assert typist.results[0].typed.corrected == 1
    assert typist.results[0].typed.uncorrected == 0


def test_a_touch_next_to_the_keys_or_after_the_last_phrase_types_nothing(wire):
    typist, hands = session(wire, "a")
    assert [each.character for each in hands.strike("q", off_mm=(-40.0, 0.0))] == [None]
    hands.strike("a", DONE, "b")
    assert typist.shown.trial is None and typist.shown.text == ""
    assert len(typist.results) == 1


def test_done_without_text_ends_nothing(wire):
    typist, hands = session(wire, "a")
    hands.strike(DONE)
    assert not typist.results


def test_with_a_pause_the_phrase_ends_by_itself_but_not_in_its_first_half(wire):
    typist, hands = session(wire, "abcd", "ef", pause_s=1.6)
    hands.type("a")
    hands.strike("b", pause_s=2.0)
    hands.strike("c", "d")
    hands.strike("e", pause_s=2.0)
    assert [result.transcribed for result in typist.results] == ["abcd"]
    assert typist.shown.text == "e"


def test_half_a_phrase_is_no_result(wire):
    typist, hands = session(wire, "abcd")
    hands.type("abc")
    typist.finish()
    assert not typist.results
    hands.type("x")
    typist.finish()
    assert [result.transcribed for result in typist.results] == ["abcx"]


def test_on_a_larger_surface_the_keyboard_is_in_its_middle(wire):
    typist, _ = session(wire, "a")
    typist.size_mm = (600.0, 400.0)
    typist.process(wire.frame(0))
    keys = typist.shown.keys
    assert keys["q"].y_mm == pytest.approx(140.0)
    assert keys["q"].x_mm + keys["p"].x_mm + 16.0 == pytest.approx(600.0)


def test_the_table_of_results_equals_values_computed_by_hand(wire, tmp_path):
    """Keys come each 0.5 s.

    "the cat" without an error: 6 characters after the first in 3.0 s: 24 words a minute.
    "a dog" as "a dpg": 4 in 2.0 s: 24; 1 of 5 wrong: accuracy 0.8, AWPM 19.2, errors 1/5.
    "cat" as c, s, delete, a, t: 2 in 2.0 s: 12; C 3, INF 0, IF 1: corrected 1/4.
    """
    typist, hands = session(wire, "the cat", "a dog", "cat")
    hands.strike(*"the cat", DONE, *"a dpg", DONE, "c", "s", DELETE, "a", "t", DONE)
    path = tmp_path / "it.csv"
    write_results(path, typist.results, "P7")
    table = list(csv.DictReader(io.StringIO(path.read_text())))
    assert list(table[0]) == list(COLUMNS)
    expected = [
        # phrase, seconds, wpm, accuracy, awpm, uncorrected, corrected, C, INF, IF
        ("1", 3.0, 24.0, 1.0, 24.0, 0.0, 0.0, 7, 0, 0),
        ("2", 2.0, 24.0, 0.8, 19.2, 0.2, 0.0, 4, 1, 0),
        ("3", 2.0, 12.0, 1.0, 12.0, 0.0, 0.25, 3, 0, 1),
        (MEAN, 7 / 3, 20.0, 2.8 / 3, 55.2 / 3, 0.2 / 3, 0.25 / 3, 14 / 3, 1 / 3, 1 / 3),
    ]
    for row, (phrase, *figures) in zip(table, expected, strict=True):
        assert (row["participant"], row["task"], row["phrase"]) == ("P7", "t", phrase)
        found = [float(row[name]) for name in COLUMNS[5:]]
        assert found == pytest.approx(figures, rel=1e-3)
    (line,) = summary(typist.results)
    assert "3 phrases, 20.0 words a minute, accuracy 93.3 %" in line


def test_free_text_has_a_speed_and_no_errors(wire):
    typist, hands = session(wire, "")
    hands.strike(*"hello", SPACE, *"you", DONE)
    (result,) = typist.results
    assert result.transcribed == "hello you"
    assert (result.typed.uncorrected, result.typed.accuracy) == (0, 1.0)
    assert "hello you" in to_csv(typist.results)
