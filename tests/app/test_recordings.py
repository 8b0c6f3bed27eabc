"""`halo simulate` and `halo record`: recordings that any reader of Matroska can open."""

from __future__ import annotations

import json
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable
from contextlib import closing
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from halo_service.app.cli import main
from halo_service.app.recordings.area import near_surface
from halo_service.app.recordings.record import copy_frames
from halo_service.canvas.layout import load as read_layout
from halo_service.geometry.camera import Camera
from halo_service.geometry.surface import from_view
from halo_service.profile import Background, Profile
from halo_service.profile.store import load, save
from halo_service.sensing.fit import surface_fit
from halo_service.sources import EndOfSource, SourceLost
from halo_service.sources.recording import Recording
from halo_service.values import BadFrame, Frame
from halo_service.virtual.camera import factory

HALO = Path(sys.executable).with_name("halo")
DEMO = "demo,mode=NFOV_2X2BINNED"
"""A quarter of the pixels: drawn and encoded sooner."""


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
    assert main(["simulate", DEMO, *files, "--seconds", "0.5", *options]) == 0
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
    assert main(["simulate", DEMO, "--out", out, "--seconds", "0.1", "--no-colour"]) == 0
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


def camera_of(path: Path) -> Camera:
    with closing(Recording(path, realtime=False, loop=False)) as recording:
        return recording.camera


def profile_of(camera: Camera, folder: Path) -> Profile:
    """A profile of a table half a metre below a camera."""
    shape = (camera.depth.height, camera.depth.width)
    flat = np.full(shape, 500.0, np.float32)
    background = Background(flat, np.ones(shape, np.float32), flat > 0)
    surface = from_view(np.array([0.0, 0.0, 1.0]), 500.0)
    save(Profile("desk", camera, surface, background, None, 1), folder)
    return load(folder)


def test_a_recording_of_the_area_alone_is_small_and_equal_there(
    recording: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    source = ["--source", f"recording:{recording}"]
    profile = profile_of(camera_of(recording), tmp_path / "desk")
    area = tmp_path / "area.mkv"
    assert main(["record", str(area), *source, "--area", str(tmp_path / "desk")]) == 0
    assert area.stat().st_size < 0.4 * recording.stat().st_size
    near = near_surface(profile)
    assert 0.2 < near.mean() < 0.6
    for all_of_it, cut in zip(frames_of(recording), frames_of(area), strict=True):
        assert cut.colour is None
        np.testing.assert_array_equal(cut.depth[near], all_of_it.depth[near])
        np.testing.assert_array_equal(cut.ir[near], all_of_it.ir[near])
        assert np.count_nonzero(cut.ir[~near]) < 0.03 * near.size
        # What tells drift and a moved table is the same.
        assert surface_fit(cut.depth, profile) == surface_fit(all_of_it.depth, profile)


def test_the_area_of_another_camera_is_refused_and_no_file_is_left(
    recording: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    profile_of(replace(camera_of(recording), serial="OTHER"), tmp_path / "desk")
    source = ["--source", f"recording:{recording}"]
    out = tmp_path / "area.mkv"
    assert main(["record", str(out), *source, "--area", str(tmp_path / "desk")]) == 2
    assert "OTHER" in capsys.readouterr().err
    assert not list(tmp_path.glob("*.mkv"))


def test_a_recording_is_not_overwritten_unless_asked(
    recording: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "evening.mkv"
    out.write_bytes(b"the only recording of that evening")
    command = ["record", str(out), "--source", f"recording:{recording}", "--no-colour"]
    assert main(command) == 2
    assert "exists already; choose another name, or add --force" in capsys.readouterr().err
    assert out.read_bytes() == b"the only recording of that evening"
    assert main([*command, "--force"]) == 0
    assert "15 frames in" in capsys.readouterr().err


class Camera30:
    """A camera that drops what is not read in time: it holds one frame, the newest."""

    kind = "camera"
    camera = factory()

    def __init__(self, frames: int, lost_at: int | None = None, bad_at: int = -1) -> None:
        self.frames, self.lost_at, self.bad_at = frames, lost_at, bad_at
        self.number = -1
        self.started_s = time.monotonic()

    def read(self, timeout_s: float) -> Frame | BadFrame:
        newest = int((time.monotonic() - self.started_s) * 100)  # a hundred frames a second
        if newest <= self.number:
            time.sleep((self.number + 1) / 100 - (time.monotonic() - self.started_s))
        self.number = max(newest, self.number + 1)
        if self.number == self.lost_at:
            raise SourceLost("the camera went away: check its cable")
        if self.number >= self.frames:
            raise EndOfSource
        if self.number == self.bad_at:
            return BadFrame(5_000_000 + self.number * 33_333, "no depth")
        empty = np.zeros((4, 4), np.uint16)
        return Frame(5_000_000 + self.number * 33_333, empty, empty)

    def close(self) -> None:
        pass


class Disk:
    """Writes for a while."""

    def __init__(self, seconds: float) -> None:
        self.seconds = seconds
        self.times_us: list[int] = []

    def write(self, frame: Frame) -> bool:
        time.sleep(self.seconds)
        self.times_us.append(frame.time_us)
        return True


@pytest.mark.parametrize("write_s", [0.0, 0.02], ids=["a fast disk", "slower than the camera"])
def test_slow_writing_does_not_delay_reading(write_s: float) -> None:
    disk = Disk(write_s)
    done = copy_frames(Camera30(50), disk, None, threading.Event())
    assert done.frames == len(disk.times_us)
    assert done.frames + done.lost == 50  # what a busy machine loses is counted
    assert done.lost <= 5
    assert disk.times_us == sorted(disk.times_us)
    assert disk.times_us[0] < 10 * 33_333


def test_frames_that_are_lost_are_counted(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("halo_service.app.recordings.record.WAITING", 2)
    done = copy_frames(Camera30(60), Disk(0.05), None, threading.Event())
    assert done.frames + done.lost >= 55
    assert done.lost > 20
    assert not done.complete


def test_what_was_recorded_until_the_camera_was_lost_is_stored() -> None:
    camera = Camera30(50, lost_at=20, bad_at=5)
    done = copy_frames(camera, Disk(0.0), None, threading.Event())
    assert done.frames + done.lost + done.bad == 20
    assert done.bad <= 1
    assert "check its cable" in done.ended
    assert done.frames > 10
    assert not done.complete


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
    slow = "close other programs" in said  # then frames are lost, and the exit code says so
    assert recorder.returncode == int(slow), said
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
        (["simulate", "demo", "--layout", "x.toml"], "'demo' has one camera and no canvas"),
        (["simulate", "crossing", "--canvas-truth", "x"], "--canvas-truth needs --seconds"),
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


def test_an_installation_has_a_layout_and_one_truth(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    layout, truth = tmp_path / "table.toml", tmp_path / "truth.jsonl"
    files = ["--layout", str(layout), "--canvas-truth", str(truth)]
    assert main(["simulate", "crossing,cameras=3,seed=4", *files, "--seconds", "8"]) == 0
    assert capsys.readouterr().err == f"next: halo canvas serve {layout}\n"
    assert [each.node for each in read_layout(layout).surface] == [
        f"camera-{number}" for number in (1, 2, 3)
    ]
    lines = [json.loads(line) for line in truth.read_text().splitlines()]
    assert sum("fingers" in line for line in lines) == 480
    assert any("contact" in line for line in lines)
    layout.write_text("changed by hand")
    again = ["simulate", "crossing,cameras=3,seed=4", "--layout", str(layout)]
    assert main(again) == 2
    assert "exists already; choose another name, or add --force" in capsys.readouterr().err
    assert layout.read_text() == "changed by hand"
    assert main([*again, "--force"]) == 0
    assert len(read_layout(layout).surface) == 3
