"""The keyboard's layout: keys without gaps, and phrases that it can type."""

import itertools

import pytest

from halo_type.layout import HEIGHT_MM, KEY_MM, SPACE, WIDTH_MM, key_at, keyboard
from halo_type.phrases import PHRASES

KEYS = keyboard(70.0, 60.0)


def test_a_touch_in_a_keys_middle_types_it_and_one_outside_does_not():
    for character, key in KEYS.items():
        assert key_at(KEYS, *key.middle) == character
        assert key.inside(*key.middle) == KEY_MM / 2.0
        assert key.inside(key.x_mm - 1.0, key.y_mm + 5.0) == -1.0
    assert key_at(KEYS, 0.0, 0.0) is None


def test_keys_do_not_overlap_and_lie_within_the_keyboard():
    for a, b in itertools.combinations(KEYS.values(), 2):
        apart_x = max(a.x_mm, b.x_mm) >= min(a.x_mm + a.width_mm, b.x_mm + b.width_mm)
        apart_y = max(a.y_mm, b.y_mm) >= min(a.y_mm + a.height_mm, b.y_mm + b.height_mm)
        assert apart_x or apart_y
    assert max(k.x_mm + k.width_mm for k in KEYS.values()) <= 70.0 + WIDTH_MM
    assert max(k.y_mm + k.height_mm for k in KEYS.values()) == 60.0 + HEIGHT_MM


def test_there_is_a_key_for_every_letter():
    assert set(KEYS) == set("abcdefghijklmnopqrstuvwxyz") | {SPACE}


@pytest.mark.parametrize("phrase", PHRASES)
def test_every_phrase_can_be_typed(phrase):
    assert set(phrase) <= set(KEYS)
    assert 12 <= len(phrase) <= 40
    assert phrase == " ".join(phrase.split())


def test_phrases_are_many_and_use_every_letter():
    assert len(PHRASES) == len(set(PHRASES)) == 60
    assert set("".join(PHRASES)) == set(KEYS)
