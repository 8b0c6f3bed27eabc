"""The touch model: probabilities, the offset that it learns, and touches that mean no key."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from halo_type.layout import SPACE, key_at, keyboard
from halo_type.touch_model import TouchModel

KEYS = keyboard(70.0, 70.0)
LETTERS = [key for character, key in KEYS.items() if character != SPACE]


@given(st.floats(0, 300), st.floats(0, 200), st.floats(0, 1))
def test_probabilities_add_up_to_1(x, y, confidence):
    found = TouchModel(KEYS).probabilities(x, y, confidence)
    assert set(found) == {*KEYS, None}
    assert math.isclose(sum(found.values()), 1.0)
    assert min(found.values()) >= 0.0


def test_the_middle_of_a_key_is_that_key_and_a_far_place_is_none():
    model = TouchModel(KEYS)
    for character, key in KEYS.items():
        assert model.probabilities(*key.middle, 0.9)[character] > 0.95
    assert model.key_at(20.0, 20.0, 0.9) is None


def test_a_touch_between_two_keys_may_be_either():
    f = KEYS["f"]
    found = TouchModel(KEYS).probabilities(f.x_mm + f.width_mm, f.middle[1], 0.9)
    assert found["f"] == pytest.approx(found["g"])
    assert found["f"] > 0.45


def test_next_to_the_keyboard_a_confident_touch_means_a_key_sooner_than_an_unsure_one():
    q = KEYS["q"]
    at = q.x_mm - 3.0, q.middle[1]
    sure, unsure = (TouchModel(KEYS).probabilities(*at, c)[None] for c in (0.95, 0.3))
    assert sure < unsure


def test_a_user_whose_touches_land_off_is_corrected_after_a_line():
    """6 mm to the left, as the paper saw 7 mm; at 9 mm the rectangles type the neighbour."""
    model = TouchModel(KEYS)
    for key in [*LETTERS, *LETTERS]:
        model.key_at(key.middle[0] - 6.0, key.middle[1] + 1.0, 0.9)
    assert model.offset_mm[0] == pytest.approx(-6.0, abs=1.5)
    x, y = KEYS["k"].middle
    assert key_at(KEYS, x - 9.0, y) == "j"
    assert model.key_at(x - 9.0, y, 0.9) == "k"


def test_the_space_bar_has_no_middle_to_learn_from():
    model = TouchModel(KEYS)
    x, y = KEYS[SPACE].middle
    for _ in range(50):
        assert model.key_at(x + 25.0, y + 5.0, 0.9) == SPACE
    assert model.offset_mm == (0.0, 0.0)
