"""Layouts: keys without overlap, phrases that they can type, and files with mistakes."""

import itertools

import pytest

from halo_type.layout import (
    DELETE,
    DONE,
    KEY_MM,
    LAYOUTS,
    SPACE,
    LayoutError,
    key_at,
    keyboard,
    load_layout,
    parse_layout,
)
from halo_type.phrases import PHRASES, PhrasesError, in_order_of_seed, read_phrases
from halo_type.typist import TOP, Trial, Typist

KEYS = keyboard(70.0, 60.0)


def test_a_touch_in_a_keys_middle_types_it_and_one_outside_does_not():
    for character, key in KEYS.items():
        assert key_at(KEYS, *key.middle) == character
        assert key.inside(*key.middle) == KEY_MM / 2.0
        assert key.inside(key.x_mm - 1.0, key.y_mm + 5.0) == -1.0
    assert key_at(KEYS, 0.0, 0.0) is None


@pytest.mark.parametrize("name", LAYOUTS)
def test_keys_do_not_overlap_and_lie_within_the_keyboard(name):
    layout = load_layout(name)
    for a, b in itertools.combinations(layout.keys, 2):
        apart_x = max(a.x_mm, b.x_mm) >= min(a.x_mm + a.width_mm, b.x_mm + b.width_mm)
        apart_y = max(a.y_mm, b.y_mm) >= min(a.y_mm + a.height_mm, b.y_mm + b.height_mm)
        assert apart_x or apart_y
    assert layout.width_mm <= 200.0
    assert layout.height_mm == 4 * KEY_MM
    assert {SPACE, DELETE, DONE} <= {key.character for key in layout.keys}


def test_the_study_s_keyboard_has_square_keys_of_16_mm_and_a_key_for_every_letter():
    assert set(KEYS) == set("abcdefghijklmnopqrstuvwxyz") | {SPACE}
    letters = [key for character, key in KEYS.items() if character != SPACE]
    assert {(key.width_mm, key.height_mm) for key in letters} == {(KEY_MM, KEY_MM)}


@pytest.mark.parametrize("name", LAYOUTS)
def test_every_layout_types_every_phrase(name):
    keys = keyboard(0.0, 0.0, name)
    for phrase in PHRASES:
        assert set(phrase) <= set(keys)
        assert 12 <= len(phrase) <= 40
        assert phrase == " ".join(phrase.split())


def test_phrases_are_many_and_use_every_letter():
    assert len(PHRASES) == len(set(PHRASES)) == 60
    assert set("".join(PHRASES)) == set(KEYS)


def test_the_virtual_typist_has_this_keyboard_at_this_place_and_these_phrases():
    from halo_service.virtual.scenarios.typing import keys, plan

    typist = Typist(load_layout("qwerty"), [Trial("t", 1, "a")])
    for character, key in keys().items():
        assert typist.shown.keys[character] == key
    assert keys()["q"].y_mm == TOP * 200.0
    order = in_order_of_seed(PHRASES, 3)
    text = "".join(order[:3])
    strokes = itertools.islice(plan(3), len(text))
    assert "".join(stroke.key.character for stroke in strokes) == text


ROW = '[[rows]]\nstart = 0\nkeys = "abc"\n'


@pytest.mark.parametrize(
    "text, message",
    [
        ("rows = [", "not TOML"),
        ("key_mm = 16.0", "no 'rows'"),
        ("rows = 3", "compare it with"),
        ("rows = []", "it has 0 keys"),
        ('rows = [{ start = 0, keys = "aa" }]', "the key 'a' twice"),
        ('rows = [{ start = -1, keys = "a" }]', "negative"),
        ('rows = [{ start = nan, keys = "a" }]', "negative"),
        (ROW + '[[wide]]\nkey = "shift"\nrow = 1\nstart = 0\nwidth = 2', "'shift'"),
        (ROW + '[[wide]]\nkey = "space"\nrow = 0\nstart = 1\nwidth = 2', "overlap"),
        (ROW + '[[wide]]\nkey = "space"\nrow = 1\nstart = 0\nwidth = 0', "size is 0"),
    ],
)
def test_a_wrong_layout_gives_one_sentence(text, message):
    with pytest.raises(LayoutError, match=message) as error:
        parse_layout(text)
    assert "\n" not in str(error.value)


def test_a_layout_of_one_s_own_is_a_file(tmp_path):
    path = tmp_path / "mine.toml"
    path.write_text('key_mm = 20.0\n[[rows]]\nstart = 0.5\nkeys = "AB"\n')
    (a, b) = load_layout(str(path)).keys
    assert (a.character, a.x_mm, a.width_mm, b.x_mm) == ("a", 10.0, 20.0, 30.0)
    for name, message in ((str(tmp_path / "no.toml"), "check the path"), ("dvorak", "choose from")):
        with pytest.raises(LayoutError, match=message):
            load_layout(name)


@pytest.mark.parametrize(
    "text, message",
    [
        ("", "has 0 phrases"),
        ("good\nschön", "no key for 'ö'"),
        ("a" * 201, "longer than"),
        (b"\xff\xfe", "not UTF-8 text"),
    ],
)
def test_a_wrong_file_of_phrases_gives_one_sentence(text, message, tmp_path):
    path = tmp_path / "mine.txt"
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    with pytest.raises(PhrasesError, match=message):
        read_phrases(path, set(KEYS))
    with pytest.raises(PhrasesError, match="check the path"):
        read_phrases(tmp_path / "none.txt", set(KEYS))


def test_phrases_of_one_s_own_lose_capitals_and_further_spaces(tmp_path):
    path = tmp_path / "mine.txt"
    path.write_text("  Two  words \n\nOne\n")
    assert read_phrases(path, set(KEYS)) == ("two words", "one")
