"""A script says what it means, or is refused."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from halo_calibration.scripted.script import parse_script, read_script, state_values_in
from halo_calibration.solvers.touch import StateValues
from halo_service.errors import UserError

GOOD = [
    {"step": "background", "from_s": 0, "to_s": 2},
    {"step": "hover", "from_s": 3, "to_s": 5, "height_mm": 12},
    {"step": "subtle", "from_s": 6, "to_s": 8, "height_mm": 1},
    {"step": "touch", "from_s": 9, "to_s": 11, "force_g": 25},
    {"step": "pressure", "from_s": 12, "to_s": 14, "force_g": 200},
    {"step": "sweep", "from_s": 15, "to_s": 35, "force_g": 25},
]
PROJECTOR = {"step": "projector", "from_s": 0, "to_s": 1, "width_px": 1280, "height_px": 800}
ANCHOR = {"step": "anchor", "from_s": 2, "to_s": 3, "marker": 4, "size_mm": 60}


def test_words_and_numbers_are_separated() -> None:
    anchor = ANCHOR | {"family": "aruco-4x4"}
    projector, marker = parse_script([PROJECTOR | {"by": "gray"}, anchor], "s.json")
    assert (projector.words, projector.fields["width_px"]) == ({"by": "gray"}, 1280.0)
    assert (marker.words, marker.fields) == ({"family": "aruco-4x4"}, {"marker": 4, "size_mm": 60})


def test_steps_come_in_the_order_of_time(tmp_path: Path) -> None:
    path = tmp_path / "s.json"
    path.write_text(json.dumps(GOOD[::-1]))
    lines = read_script(path)
    assert [line.step for line in lines] == [line["step"] for line in GOOD]
    assert state_values_in(lines, StateValues(hover_mm=9.0)) == StateValues(12.0, 1.0, 25.0, 200.0)


def test_a_hard_press_is_held_where_the_script_has_it() -> None:
    hard = {"step": "hard", "from_s": 14, "to_s": 15, "force_g": 400}
    lines = parse_script([*GOOD, hard], "s.json")
    assert state_values_in(lines, StateValues()).to_hold[-1] == "hard"
    before = StateValues(pressure_g=200.0, hard_g=400.0)
    assert state_values_in(parse_script(GOOD, "s.json"), before).hard_g is None


def changed(index: int, **fields: object) -> list[dict[str, object]]:
    lines: list[dict[str, object]] = [dict(line) for line in GOOD]
    lines[index].update(fields)
    return lines


@pytest.mark.parametrize(
    ("data", "says"),
    [
        ({}, "must be a list"),
        ([], "must be a list"),
        ([{"step": "hover"}], "needs step, from_s, to_s"),
        (changed(0, step="dance"), "known: background, surface"),
        (changed(1, colour="red"), "has no field 'colour'"),
        (changed(1, to_s=7), "'hover' and 'subtle' overlap"),
        (changed(1, to_s=2.5), "must end after it begins"),
        (changed(1, to_s="5"), "must be a number"),
        (changed(1, to_s=True), "must be a number"),
        (changed(5, step="background"), "names 'background' twice|has no field"),
        (GOOD[:3], "lacks touch, pressure"),
        ([{"step": "hard", "from_s": 0, "to_s": 1, "force_g": 400}], "lacks hover, subtle"),
        ([*GOOD, {"step": "hard", "from_s": 14, "to_s": 15}], "'hard' needs force_g"),
        (changed(0, by="touch"), "has no field 'by'"),
        ([PROJECTOR | {"by": "magic"}], "by of 'projector' must be one of markers, gray, touch"),
        ([PROJECTOR | {"by": 3}], "must be one of markers"),
        ([{"step": "projector", "from_s": 0, "to_s": 1}], "needs width_px and height_px"),
        ([ANCHOR | {"family": "qr"}], "must be one of aruco-4x4, apriltag-36h11"),
        ([ANCHOR | {"marker": "zero"}], "marker of 'anchor' must be a number"),
    ],
)
def test_what_is_no_script_is_refused(data: object, says: str) -> None:
    with pytest.raises(UserError, match=says):
        parse_script(data, "s.json")


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16"])
def test_a_script_by_a_windows_editor_is_read(tmp_path: Path, encoding: str) -> None:
    path = tmp_path / "s.json"
    path.write_bytes(json.dumps(GOOD, indent=1).replace("\n", "\r\n").encode(encoding))
    assert read_script(path) == parse_script(GOOD, "s.json")


def test_a_script_in_another_encoding_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "s.json"
    path.write_bytes('[{"step": "Fläche"}]'.encode("latin-1"))
    with pytest.raises(UserError, match=r"not UTF-8 text .* save it as UTF-8"):
        read_script(path)


def test_a_script_that_is_no_json_is_one_sentence(tmp_path: Path) -> None:
    path = tmp_path / "s.json"
    path.write_text("{")
    with pytest.raises(UserError, match="cannot be read"):
        read_script(path)
