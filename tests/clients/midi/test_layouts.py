"""The table of layouts: each place has its note, and a finger that moves bends it."""

from __future__ import annotations

import pytest

from halo_midi.layouts import LAYOUTS, SCALES, board, note_name, note_number


@pytest.mark.parametrize(
    ("layout", "root", "u", "v", "pitch"),
    [
        ("grid", None, 0.01, 0.99, 48), ("grid", None, 0.2, 0.99, 49), ("grid", None, 0.0, 0.7, 53),
        ("grid", None, 1.0, 0.0, 48 + 7 + 4 * 5), ("grid", 60, -0.5, 1.5, 60),
        ("keys", None, 0.01, 0.9, 48), ("keys", None, 1 / 14, 0.3, 49), ("keys", 36, 0.1, 0.9, 38),
        ("keys", None, 0.25, 0.3, 53), ("keys", None, 1.0, 0.1, 71),
        ("scale", None, 0.0, 0.5, 48), ("scale", None, 0.16, 0.5, 52), ("scale", 40, 1.0, 0.5, 64),
        ("drums", None, 0.1, 0.9, 36), ("drums", None, 0.9, 0.1, 51),
        ("ribbon", None, 0.0, 0.5, 48), ("ribbon", None, 0.5, 0.5, 66), ("ribbon", 36, 0.25, 0, 45),
    ],
)  # fmt: skip
def test_each_place_has_its_pitch(
    layout: str, root: int | None, u: float, v: float, pitch: float
) -> None:
    assert board(layout, root).pitch(u, v) == pytest.approx(pitch)


@pytest.mark.parametrize("layout", LAYOUTS)
@pytest.mark.parametrize("scale", SCALES)
def test_no_layout_has_a_hole_or_a_note_outside_midi(layout: str, scale: str) -> None:
    keys = board(layout, None, scale)
    for u in range(0, 101, 2):
        for v in range(0, 101, 10):
            key = keys.key(u / 100, v / 100)
            assert 0 <= key.note <= 127
            assert 0.0 <= key.slide(v / 100) <= 1.0


def test_slide_grows_from_the_near_to_the_far_edge_of_a_key() -> None:
    key = board("grid").key(0.5, 0.5)
    _, far, _, near = key.area
    assert [key.slide(v) for v in (near, (near + far) / 2, far, far - 1)] == pytest.approx(
        [0.0, 0.5, 1.0, 1.0]
    )


@pytest.mark.parametrize(
    ("name", "number"),
    [
        ("C4", 60),
        ("c4", 60),
        ("C-1", 0),
        ("F#2", 42),
        ("Bb3", 58),
        ("bb3", 58),
        ("60", 60),
        ("G9", 127),
    ],
)
def test_notes_have_names(name: str, number: int) -> None:
    assert note_number(name) == number
    assert note_number(note_name(number)) == number


@pytest.mark.parametrize("name", ["", "H3", "C", "C99", "-1", "128", "4C"])
def test_what_is_no_note_is_refused(name: str) -> None:
    with pytest.raises(ValueError):
        note_number(name)
