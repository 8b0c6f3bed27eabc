"""The guided session under a real camera: its requests become the script."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from halo_calibration.errors import CalibrationError
from halo_service.app.cli import main
from halo_service.app.evaluation_ui.guided import (
    Prompt,
    conduct,
    require_crosses,
    session_prompts,
)
from halo_service.errors import UserError
from halo_service.evaluation.study.sense import FrameSequence
from halo_service.geometry.surface import Surface
from halo_service.outputs.recorder import Recorder
from halo_service.profile import Profile, StepRecord
from halo_service.profile.store import save
from halo_service.values import BadFrame, Frame
from halo_service.virtual.camera import factory
from halo_service.virtual.scenarios.study import targets

FRAME_US = 33_333
UNIX_US = 1_700_000_000_000_000
NOTHING = np.zeros((2, 2), np.uint16)


def live(count: int) -> Iterator[Frame | BadFrame]:
    """Frames as a camera stamps them; every hundredth is bad."""
    for index in range(count):
        time_us = UNIX_US + index * FRAME_US
        bad = index % 100 == 99
        yield BadFrame(time_us, "torn") if bad else Frame(time_us, NOTHING, NOTHING)


BY_VIEW = StepRecord("2026-01-01T00:00:00Z", "good", {"residual_mm": 0.3})
BY_MARKERS = StepRecord("2026-01-01T00:00:00Z", "good", {"error_mm": 0.3, "print_scale": 1.0})


def surface_of(width_mm: float, height_mm: float) -> Surface:
    return Surface("table", width_mm, height_mm, np.eye(4))


@pytest.fixture
def found(profile: Profile) -> Profile:
    """A profile with a surface that was found on the printed sheet."""
    return replace(profile, steps={"surface": BY_MARKERS})


def test_the_session_has_the_papers_targets_heights_and_forces() -> None:
    prompts = list(session_prompts(surface_of(300.0, 200.0)))
    steps = [prompt.step for prompt in prompts]
    assert {name: steps.count(name) for name in steps} == {
        "target": 32,
        "hover": 10,
        "pressure": 10,
    }
    assert 200.0 < sum(prompt.ready_s + prompt.seconds for prompt in prompts) < 300.0
    crosses = [tuple(prompt.fields["target_mm"]) for prompt in prompts if prompt.step == "target"]
    assert crosses == 2 * targets()


def test_the_crosses_lie_around_the_middle_of_the_profiles_surface() -> None:
    prompts = [
        prompt for prompt in session_prompts(surface_of(400.0, 180.0)) if prompt.step == "target"
    ][:16]
    assert prompts[0].words == "Touch cross 1-1 once."
    assert prompts[0].fields["target_mm"] == [125.0, 15.0]
    assert prompts[7].words == "Touch cross 2-4 once."
    assert prompts[7].fields["target_mm"] == [275.0, 65.0]
    assert np.mean([prompt.fields["target_mm"] for prompt in prompts], axis=0) == pytest.approx(
        [200, 90]
    )


@pytest.mark.parametrize(
    ("changes", "sentence"),
    [
        ({"touch": None}, "has no touch states"),
        ({"steps": {}}, "--by markers"),
        (
            {"steps": {"surface": BY_VIEW}},
            "the positions of the crosses are unknown: put the surface sheet there",
        ),
        ({"surface": surface_of(300.0, 169.0)}, "300 x 169 mm, and the crosses need 170 x 170 mm"),
        ({"surface": surface_of(150.0, 200.0)}, "150 x 200 mm, and the crosses need 170 x 170 mm"),
    ],
)
def test_a_profile_that_does_not_know_where_the_crosses_are_is_refused(
    changes: dict[str, object], sentence: str, found: Profile
) -> None:
    require_crosses(found)
    require_crosses(replace(found, surface=surface_of(170.0, 170.0)))
    with pytest.raises(UserError) as refused:
        require_crosses(replace(found, **changes))  # type: ignore[arg-type]
    assert sentence in str(refused.value)
    assert "run 'halo calibrate " in str(refused.value)


def test_the_virtual_tables_targets_are_around_the_middle_of_its_view(found: Profile) -> None:
    require_crosses(replace(found, camera=factory(), steps={"surface": BY_VIEW}))


def test_prompts_go_to_stderr_and_half_a_session_leaves_no_file(
    found: Profile,
    draw: Callable[..., Frame],
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:
    # This camera has no colour, so only --no-colour can record it.
    with Recorder(tmp_path / "recording.mkv", found.camera, fps=30, colour=False) as recorder:
        for index in range(3):
            recorder.write(draw(time_us=index * FRAME_US))
    save(found, tmp_path / "profile")
    options = ("--profile", str(tmp_path / "profile"), "--no-colour", "--csv", "-")
    source = f"recording:{tmp_path / 'recording.mkv'}"
    folder = tmp_path / "first-light"
    assert main(["evaluate", "--live", str(folder), "--source", source, *options]) == 2
    printed = capsys.readouterr()
    assert "Touch cross 1-1 once." in printed.err
    assert "the recording ended during 'target'" in printed.err
    assert printed.out == ""
    assert list(folder.iterdir()) == []


@pytest.mark.parametrize(
    "command",
    [
        ["evaluate", "recording.mkv", "--truth", "t.jsonl"],
        ["evaluate", "--live", "folder"],
        ["bench", "--source", "recording:recording.mkv"],
    ],
)
def test_a_profile_without_touch_states_is_refused_before_anything_is_opened(
    command: list[str],
    found: Profile,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    save(replace(found, touch=None), tmp_path / "profile")
    (tmp_path / "t.jsonl").touch()
    assert main([*command, "--profile", "./profile"]) == 2
    assert "the profile drawn has no touch states" in capsys.readouterr().err
    assert {path.name for path in tmp_path.iterdir()} == {"profile", "t.jsonl"}


def test_the_script_is_on_the_recordings_own_clock() -> None:
    prompts = [
        Prompt("Touch it.", 0.0, 2.0, "target", {"target_mm": [10.0, 20.0]}),
        Prompt("Hold it.", 1.0, 3.0, "hover", {"height_mm": 5.0}),
    ]
    said: list[str] = []
    frames: list[Frame] = []
    lines = conduct(prompts, FrameSequence(live(1000)), said.append, frames.append)
    assert said == ["Touch it.", "Hold it."]
    assert frames[0].time_us == 0
    assert [line["step"] for line in lines] == ["target", "hover"]
    assert lines[0]["target_mm"] == [10.0, 20.0]
    assert lines[1]["height_mm"] == 5.0
    times = [(line["from_s"], line["to_s"]) for line in lines]
    assert times[0] == pytest.approx((0.0, 2.0), abs=0.04)
    assert times[1] == pytest.approx((3.0, 6.0), abs=0.08)
    assert frames[-1].time_us / 1e6 == pytest.approx(times[1][1])


def test_a_camera_that_ends_during_the_session_is_refused() -> None:
    prompts = [Prompt("Touch it.", 0.0, 9.0, "target", {"target_mm": [10.0, 20.0]})]
    with pytest.raises(CalibrationError, match="during 'target'"):
        conduct(prompts, FrameSequence(live(60)), lambda _: None, lambda _: None)
