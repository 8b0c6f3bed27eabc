"""A layout file answers back, and its matrices mean what the file says."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from halo_service.canvas.layout import load
from halo_service.errors import UserError

SIZE = "width_mm = 560.0\nheight_mm = 200.0\n"
TWO = SIZE + '[[surface]]\nnode = "left"\n[[surface]]\nnode = "right"\nx_mm = 260.0\n'
PICTURE = "[[projector]]\nwidth_px = 1280\nheight_px = 800\n"
CORNERS = "points = [[0, 0, 0, 0], [280, 0, 1280, 0], [280, 200, 1280, 800], [0, 200, 0, 800]]\n"


def test_what_is_not_set_has_a_default(tmp_path: Path) -> None:
    (file := tmp_path / "layout.toml").write_text(TWO)
    layout = load(file)
    assert (layout.name, layout.width_mm, layout.height_mm) == ("table", 560.0, 200.0)
    assert [(each.node, each.surface, each.x_mm) for each in layout.surface] == [
        ("left", "table", 0.0),
        ("right", "table", 260.0),
    ]


def test_a_positive_angle_turns_clockwise_as_seen_from_above(tmp_path: Path) -> None:
    (file := tmp_path / "layout.toml").write_text(TWO + "y_mm = 10\nangle_deg = 90\n")
    matrix = load(file).surface[1].canvas_from_surface
    # x goes right and y towards the user, so a quarter turn clockwise takes x to y.
    assert np.allclose(matrix @ (7.0, 0.0, 1.0), (260.0, 17.0, 1.0))
    assert np.allclose(matrix @ (0.0, 7.0, 1.0), (253.0, 10.0, 1.0))


def test_four_points_and_a_matrix_place_a_projector_alike(tmp_path: Path) -> None:
    matrix = "projector_from_canvas = [[8, 0, 0], [0, 8, 0], [0, 0, 2]]\n"
    (file := tmp_path / "layout.toml").write_text(
        f'{TWO}{PICTURE}{matrix}{PICTURE}name = "right"\n'
        "points = [[0, 0, 0, 0], [100, 0, 400, 0], [100, 100, 400, 400], [0, 100, 0, 400]]\n"
    )
    one, other = load(file).projector
    assert np.allclose(one.matrix, np.diag((4.0, 4.0, 1.0)))
    assert np.allclose(other.matrix, one.matrix, atol=1e-9)
    assert [load(file).surface_name(each) for each in (one, other)] == ["table", "table-right"]


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("name = \n", "the layout"),
        (SIZE, "the canvas has no surface; add a table [[surface]] for each node"),
        (TWO.replace("560.0", "0"), "'width_mm' must be more than 0, not 0"),
        (TWO.replace("560.0", "inf"), "'width_mm' must be more than 0"),
        (TWO.replace("width_mm = 560.0\n", ""), "'width_mm' is missing"),
        (TWO + "w_mm = 3\n", "surface 2: unknown key 'w_mm'; known: node, surface, x_mm, y_mm"),
        (TWO + "y_mm = 'a'\n", "surface 2: 'y_mm' must be a number, not 'a'"),
        (TWO + "angle_deg = nan\n", "surface 2: 'angle_deg' must be"),
        (SIZE + "[[surface]]\nx_mm = 1\n", "surface 1: 'node' is missing"),
        (SIZE + "surface = 3\n", "'surface' must be tables: [[surface]]"),
        (SIZE + "surface = [3]\n", "'surface' must be tables: [[surface]]"),
        (TWO.replace("right", "left"), "surface 'table' of node 'left' is placed twice"),
        (TWO.replace("right", "Right"), "surface 2: 'node' must be text that matches"),
        (TWO + PICTURE, "projector 1: write either 'points' or 'projector_from_canvas'"),
        (TWO + PICTURE + "points = [[0, 0, 0, 0]]\n", "'points' must be four or more, not 1"),
        (TWO + PICTURE + "points = [[0, 0, 0]]\n", "projector 1: 'points'"),
        (
            TWO + PICTURE + "points = [[0, 0, 0, 0], [1, 1, 9, 0], [2, 2, 9, 9], [3, 3, 0, 9]]\n",
            "must not be on one line",
        ),
        (TWO + PICTURE + "projector_from_canvas = [[1, 0], [0, 1]]\n", "3 x 3 matrix"),
        (
            TWO + PICTURE + "projector_from_canvas = [[1, 0, 0], [1, 0, 0], [0, 0, 1]]\n",
            "'projector_from_canvas' has no inverse",
        ),
        (TWO + (PICTURE + CORNERS) * 2, "two projectors have one name"),
    ],
)
def test_what_is_wrong_is_said_in_one_sentence(tmp_path: Path, text: str, says: str) -> None:
    (file := tmp_path / "layout.toml").write_text(text)
    with pytest.raises(UserError) as error:
        load(file)
    (sentence,) = str(error.value).splitlines()
    assert says in sentence
    assert str(file) in sentence


def test_a_quarter_turn_keeps_lengths(tmp_path: Path) -> None:
    (file := tmp_path / "layout.toml").write_text(TWO + "angle_deg = 33\n")
    matrix = load(file).surface[1].canvas_from_surface
    assert math.isclose(np.linalg.det(matrix), 1.0)
