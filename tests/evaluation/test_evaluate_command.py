"""`halo evaluate`: its options, its errors, and the evaluation of a recording."""

from __future__ import annotations

import csv
import json
import shutil
from dataclasses import replace
from pathlib import Path

import pytest

from halo_service.app.cli import main
from halo_service.app.evaluation_ui import evaluate as study
from halo_service.app.virtual_user.cache import cached_profile
from halo_service.app.virtual_user.profile import virtual_profile
from halo_service.errors import UserError
from halo_service.profile.store import load, save
from halo_service.settings import Settings
from halo_service.virtual.sim_url import parse_sim_url
from tests.kind_sensor import KIND_URL


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (["--method", "ours,theirs"], "unknown method 'theirs'; choose from: ours"),
        (["--materials", "stone"], "unknown material 'stone'; choose from: paper, wood"),
        (
            ["--quick", "--tasks", "juggling"],
            "unknown task 'juggling'; choose from: hover-5, pointing-20",
        ),
        (["--modes", "WIDE"], "unknown depth mode 'WIDE'; choose from: NFOV_UNBINNED"),
        (["--cached-only", "--modes", "WIDE"], "unknown depth mode 'WIDE'; choose from: NFOV_UNB"),
        (["--quick", "--heights", "50"], "camera_height_mm is 50; give 300 to 1500"),
        (["--labels", "nowhere"], "no label file (*.txt) in nowhere"),
        (["--cached-only"], "no cached recordings of these users and materials"),
        (["--truth", "t.jsonl", "--tasks", "juggling"], "the study, which does not use --truth:"),
        (["--source", "recording:x", "--tasks", "juggling"], "does not use --source:"),
        (["--no-colour", "--tasks", "juggling"], "does not use --no-colour: leave"),
        (["--profile", "desk", "--tasks", "juggling"], "does not use --profile: leave --profile"),
        (["--quick", "--labels", "nowhere", "--tasks", "juggling"], "--quick does not use --lab"),
        (["--cached-only", "--labels", "nowhere"], "--cached-only does not use --labels:"),
        (["--cached-only", "--quick"], "--cached-only does not use --quick:"),
        (
            ["--each", "--markdown", "--tasks", "juggling"],
            "--each does not use --markdown: leave",
        ),
        (["--csv", "-", "--each", "--tasks", "juggling"], "--csv - does not use --each: leave"),
        (["--csv", "-", "--markdown"], "--csv - does not use --markdown: leave --markdown out"),
        (["--live", "here", "--quick"], "--live does not use --quick, --cache: leave --quick"),
        (["--live", "here", "--truth", "t.jsonl"], "--live does not use --truth, --cache:"),
        (["recording.mkv", "--live", "here"], "--live does not use RECORDING: leave RECORDING out"),
        (
            ["recording.mkv", "--truth", "t.jsonl", "--users", "201"],
            "RECORDING does not use --users:",
        ),
        (
            ["recording.mkv", "--truth", "t.jsonl", "--source", "s"],
            "RECORDING does not use --source:",
        ),
        (["recording.mkv"], "needs --truth T.jsonl or --script S.json"),
        (["recording.mkv", "--truth", "t.jsonl"], "name the profile of the recording"),
        (
            ["recording.mkv", "--truth", "t.jsonl", "--profile", "./none"],
            "there is no profile at none",
        ),
    ],
)
def test_wrong_options_are_answered_with_one_sentence(
    arguments: list[str],
    sentence: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    if "recording.mkv" not in arguments:
        arguments = [*arguments, "--cache", "recordings"]
    assert main(["evaluate", *arguments]) == 2
    printed = capsys.readouterr()
    assert sentence in printed.err
    assert printed.out == ""
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("option", "text"), [("--users", "301,-2"), ("--users", "all"), ("--jobs", "0")]
)
def test_wrong_numbers_are_refused(
    option: str, text: str, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit):
        main(["evaluate", option, text])
    assert f"argument {option}: {text!r} must be" in capsys.readouterr().err


def test_hours_of_work_begin_only_after_a_question(tmp_path: Path) -> None:
    asked: list[float] = []

    def refuse(hours: float) -> bool:
        asked.append(hours)
        return False

    with pytest.raises(UserError, match="nothing was run; 'halo evaluate --quick'"):
        study.evaluate(Settings(), study.StudyOptions(cache=tmp_path, jobs=2), refuse)
    assert asked[0] > 1.0
    assert list(tmp_path.iterdir()) == []


def test_an_unknown_method_is_refused_before_a_session_begins(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(["evaluate", "--live", "here", "--method", "ours,theirs"]) == 2
    assert "unknown method 'theirs'; choose from: ours" in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == []


def test_cached_recordings_of_labels_are_in_the_plan(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "201-wood").mkdir()
    for name in ("calibration", "labels-05_1", "pointing", "another"):
        (tmp_path / "201-wood" / f"{name}.npz").touch()
    assert main(["evaluate", "--cached-only", "--cache", str(tmp_path), "--tasks", "juggling"]) == 2
    assert (
        "unknown task 'juggling'; choose from: labels-05_1, pointing\n" in capsys.readouterr().err
    )


@pytest.mark.parametrize(
    ("sensor", "tasks"), [((), "hover, pointing"), (("--sensor", "kind"), "pointing")]
)
def test_cached_recordings_of_another_sensor_are_in_the_plan(
    sensor: tuple[str, ...], tasks: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    for user, task in (("201-wood", "hover"), ("202-paper-kind", "pointing")):
        (tmp_path / user).mkdir()
        for name in ("calibration", task):
            (tmp_path / user / f"{name}.npz").touch()
    cached = ("--cached-only", "--cache", str(tmp_path), *sensor)
    assert main(["evaluate", *cached, "--tasks", "juggling"]) == 2
    assert f"unknown task 'juggling'; choose from: {tasks}\n" in capsys.readouterr().err


MODE = "mode=NFOV_2X2BINNED"
"""A quarter of the pixels: drawn, written and read sooner."""


@pytest.fixture(scope="module")
def desk(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a recording of an empty table, its truth, and a profile of its room."""
    folder = tmp_path_factory.mktemp("desk")
    taken = ("--out", str(folder / "desk.mkv"), "--truth", str(folder / "truth"), "--no-colour")
    idle = f"idle?seed=205&{MODE}&{KIND_URL}"
    assert main(["simulate", idle, *taken, "--seconds", "0.3"]) == 0
    save(
        cached_profile(parse_sim_url(f"sim:{idle}").room, Settings(), virtual_profile),
        folder / "profile",
    )
    return folder


def methods_of(desk: Path, profile: Path, figures: Path, *options: str) -> set[str]:
    """Evaluate the recording of the empty table, and return the methods that did."""
    given = ("--truth", str(desk / "truth"), "--profile", str(profile), "--csv", str(figures))
    assert main(["evaluate", str(desk / "desk.mkv"), *given, *options]) == 0
    with figures.open(encoding="utf-8", newline="") as file:
        return {row["method"] for row in csv.DictReader(file)}


def test_a_recording_is_evaluated_by_the_methods_that_read_its_profile(
    desk: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    methods = methods_of(desk, desk / "profile", tmp_path / "figures")
    assert methods == {"ours", "direct", "wilson"}
    text = capsys.readouterr().out
    assert "recording desk, compared with its truth\n" in text
    assert "virtual" not in text


def test_methods_that_need_the_empty_surface_alone_need_no_touch_states(
    desk: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    save(replace(load(desk / "profile"), touch=None), tmp_path / "empty")
    rivals = methods_of(desk, tmp_path / "empty", tmp_path / "figures", "--method", "direct,wilson")
    assert rivals == {"direct", "wilson"}
    given = ("--truth", str(desk / "truth"), "--profile", str(tmp_path / "empty"))
    for name in ("direct,ours", "paper"):
        assert main(["evaluate", str(desk / "desk.mkv"), *given, "--method", name]) == 2
        assert "has no touch states" in capsys.readouterr().err


@pytest.fixture(scope="module")
def recorded(desk: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a recording of three touches, its truth, and a profile of its room."""
    folder = tmp_path_factory.mktemp("recorded")
    files = ("--out", str(folder / "recording.mkv"), "--truth", str(folder / "truth.jsonl"))
    # The third touch ends at 3.05 s.
    length = ("--seconds", "3.3", "--no-colour")
    assert main(["simulate", f"demo?seed=205&{MODE}", *files, *length]) == 0
    shutil.copytree(desk / "profile", folder / "profile")  # the room is the seed's alone
    return folder


def evaluate(recording: Path, *options: str) -> int:
    profile = ("--profile", str(recording.parent / "profile"))
    return main(["evaluate", str(recording), *profile, "--method", "ours", *options])


def test_where_the_truth_is_unknown_the_script_is_used(desk: Path, tmp_path: Path) -> None:
    script = [{"step": "target", "from_s": 0.0, "to_s": 0.3, "target_mm": [150.0, 100.0]}]
    (tmp_path / "script.json").write_text(json.dumps(script))
    files = ("--script", str(tmp_path / "script.json"), "--csv", str(tmp_path / "figures.csv"))
    assert evaluate(desk / "desk.mkv", *files) == 0
    with (tmp_path / "figures.csv").open(encoding="utf-8", newline="") as file:
        figures = {row["figure"]: row["value"] for row in csv.DictReader(file)}
    assert (figures["touches"], figures["missed"]) == ("1", "1")


@pytest.mark.slow
def test_a_recording_is_compared_with_its_truth(
    recorded: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    lines = [json.loads(line) for line in (recorded / "truth.jsonl").read_text().splitlines()]
    contacts = sum("contact" in line for line in lines)
    options = ("--truth", str(recorded / "truth.jsonl"), "--report", str(tmp_path / "report"))
    assert (
        evaluate(recorded / "recording.mkv", *options, "--csv", str(tmp_path / "figures.csv")) == 0
    )
    with (tmp_path / "figures.csv").open(encoding="utf-8", newline="") as file:
        figures = {row["figure"]: float(row["value"]) for row in csv.DictReader(file)}
    assert figures["touches"] == contacts >= 3
    assert figures["recall"] >= 0.5  # only that there is something to score
    assert "The paper's figures and ours" in capsys.readouterr().out
    assert (tmp_path / "report" / "index.html").read_text().startswith("<!doctype html>")


@pytest.mark.parametrize("text", ['{"time_us": 1}', '{"fingers": 3, "time_us": 1}', "[1]", "no"])
def test_a_wrong_truth_is_refused_and_nothing_is_written(
    text: str, desk: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "truth.jsonl").write_text(text)
    files = ("--truth", str(tmp_path / "truth.jsonl"), "--csv", str(tmp_path / "figures.csv"))
    assert evaluate(desk / "desk.mkv", *files) == 2
    assert "truth" in capsys.readouterr().err
    assert [path.name for path in tmp_path.iterdir()] == ["truth.jsonl"]
