"""`halo simulate` and `halo record`: recordings that any reader of Matroska can open."""

from __future__ import annotations

import json
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from halo_service.app.cli import main
from halo_service.sources import EndOfSource
from halo_service.sources.recording import Recording
from halo_service.values import Frame

HALO = Path(sys.executable).with_name("halo")


def frames_of(path: Path) -> list[Frame]:
    recording = Recording(path, realtime=False, loop=False)
    frames: list[Frame] = []
    try:
        while True:
            capture = recording.read(1.0)
            assert isinstance(capture, Frame)
            frames.append(capture)
    except EndOfSource:
        recording.close()
    return frames


def simulate(folder: Path, *options: str) -> Path:
    files = ("--out", str(folder / "x.mkv"), "--truth", str(folder / "x.truth.jsonl"))
    assert main(["simulate", "demo", *files, "--seconds", "0.5", *options]) == 0
    return folder / "x.mkv"


@pytest.fixture(scope="module")
def recording(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return simulate(tmp_path_factory.mktemp("recording"), "--seed", "3")


def test_the_same_seed_gives_the_same_bytes_and_another_does_not(
    recording: Path, tmp_path: Path
) -> None:
    (tmp_path / "same").mkdir()
    (tmp_path / "other").mkdir()
    assert simulate(tmp_path / "same", "--seed", "3").read_bytes() == recording.read_bytes()
    assert simulate(tmp_path / "other", "--seed", "4").read_bytes() != recording.read_bytes()


def test_each_frame_has_its_truth(recording: Path) -> None:
    truth = recording.with_suffix(".truth.jsonl").read_text()
    lines = [json.loads(line) for line in truth.splitlines()]
    listed = [line["time_us"] for line in lines if "fingers" in line]
    assert listed == [frame.time_us for frame in frames_of(recording)]


def test_the_commands_say_that_truth_and_profile_are_absent(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = str(tmp_path / "x.mkv")
    assert main(["simulate", "demo", "--out", out, "--seconds", "0.1", "--no-colour"]) == 0
    assert "no ground truth; --truth X.jsonl writes it" in capsys.readouterr().err
    assert main(["replay", out, "--jsonl", str(tmp_path / "x.jsonl")]) == 0
    assert "no profile: the frames have no touches; add --profile" in capsys.readouterr().err


def test_a_recording_can_be_recorded(recording: Path, tmp_path: Path) -> None:
    copy = tmp_path / "copy.mkv"
    assert main(["record", str(copy), "--source", f"recording:{recording}", "--no-colour"]) == 0
    for original, copied in zip(frames_of(recording), frames_of(copy), strict=True):
        assert copied.time_us == original.time_us
        assert copied.colour is None
        np.testing.assert_array_equal(copied.depth, original.depth)
        np.testing.assert_array_equal(copied.ir, original.ir)


@pytest.mark.slow
def test_ctrl_c_ends_a_live_recording_and_saves_it(
    spawn: Callable[..., subprocess.Popen[str]], tmp_path: Path
) -> None:
    out = tmp_path / "live.mkv"
    recorder = spawn(HALO, "record", out, "--source", "sim", "--no-colour")
    until = time.monotonic() + 60.0
    while time.monotonic() < until:  # until some frames are on the disk
        if sum(path.stat().st_size for path in tmp_path.iterdir()) > 1_000_000:
            break
        time.sleep(0.1)
    recorder.send_signal(signal.SIGINT)
    _, said = recorder.communicate(timeout=30.0)
    assert recorder.returncode == 0, said
    assert frames_of(out)[0].time_us == 0
    assert [path.name for path in tmp_path.iterdir()] == ["live.mkv"]


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (["simulate", "nowhere", "--out", "x.mkv"], "has no scenario 'nowhere'; choose from: demo"),
        (["simulate", "demo", "--out", "x.mkv"], "never ends by itself; give its length"),
        (["simulate", "demo", "--out", "x.mkv", "--seconds", "-1"], "cannot be -1 s long"),
        (
            ["simulate", "demo?material=jelly", "--out", "x.mkv", "--seconds", "1"],
            "choose from: paper",
        ),
        (["simulate", "demo?camera_height_mm=-5", "--out", "x.mkv", "--seconds", "1"], "give 300"),
        (
            ["simulate", "demo?speed=3", "--out", "x.mkv", "--seconds", "1"],
            "did you mean 'seed'?",
        ),
        (
            ["simulate", "demo", "--out", "no/x.mkv", "--seconds", "0.1"],
            "/no does not exist; create",
        ),
        (
            ["simulate", "demo", "--out", "x.mkv", "--truth", "no/x", "--seconds", "0.1"],
            "cannot be written",
        ),
        (["simulate", "demo"], "simulate needs a SCENARIO and --out"),
        (["record", "x.mkv", "--source", "recording:none.mkv"], "none.mkv does not exist"),
        (["record", "no/x.mkv", "--source", "sim"], "no/x.mkv cannot be written: the folder"),
    ],
)
def test_an_impossible_recording_leaves_nothing(
    arguments: list[str],
    says: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(arguments) == 2
    assert says in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == []
