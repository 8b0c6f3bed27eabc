"""Results of steps are sentences with units and good ranges, for each figure that is stored."""

from __future__ import annotations

import ast
from pathlib import Path

import pytest

import halo_calibration.steps
from halo_service.app.calibration_ui.verdict import FIGURES, step_line, step_sentence
from halo_service.app.cli import main
from halo_service.profile import StepRecord


def test_a_result_is_a_sentence_with_units_and_good_ranges() -> None:
    record = StepRecord("2026-01-01", "fair", {"noise_mm": 1.25, "measured_share": 0.9}, "so")
    assert step_line("background", record) == (
        "background: fair. Depth noise 1.2 mm (good: up to 2 mm), 90 % of the picture is measured "
        "(good: from 50 %). Note: so."
    )


@pytest.mark.parametrize(("figures", "good"), [({"print_scale": 1.0}, "0.7"), ({}, "3")])
def test_a_surface_is_judged_by_the_way_that_it_was_found(
    figures: dict[str, float], good: str
) -> None:
    record = StepRecord("2026-01-01", "good", {"error_mm": 0.5, **figures})
    assert f"Error 0.5 mm (good: below {good} mm)" in step_sentence("surface", record)


def test_a_figure_of_a_newer_version_is_shown_as_it_is() -> None:
    record = StepRecord("2026-01-01", "good", {"new_mm": 3.5})
    assert step_sentence("sweep", record) == "New_mm 3.5."


def test_the_terminal_judges_the_camera_as_the_page_does(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    source = ["--source", "sim:calibration,mode=NFOV_2X2BINNED"]
    assert main(["calibrate", "camera", *source, "--profile", str(tmp_path / "new")]) == 0
    said = capsys.readouterr().err
    assert "\n██████" in said and "camera: good." in said
    assert "Still missing: background, touch, sweep." in said


def test_every_figure_that_a_step_stores_has_words() -> None:
    folder = Path(halo_calibration.steps.__file__).parent
    stored = {
        keyword.arg
        for path in folder.glob("*.py")
        for node in ast.walk(ast.parse(path.read_text()))
        if isinstance(node, ast.Call) and ast.unparse(node.func) == "rounded"
        for keyword in node.keywords
        if keyword.arg is not None
    }
    assert len(stored) > 12
    assert stored <= {each.split(" ")[1] for each in FIGURES}
