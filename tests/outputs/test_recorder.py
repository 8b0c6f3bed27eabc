"""Recordings read back equal, and are complete or absent."""

import os
import shutil
import subprocess
import sys
import textwrap
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest

from halo_service.errors import UserError
from halo_service.geometry.camera import Camera, Lens
from halo_service.outputs.recorder import Recorder
from halo_service.sources import EndOfSource
from halo_service.sources.recording import Recording
from halo_service.values import Frame

SHAPE = (288, 320)
CAMERA = Camera(
    serial="0123",
    depth_mode="NFOV_2X2BINNED",
    fps=30,
    depth=Lens(320, 288, 252.0, 252.5, 160.25, 144.0, (0.5, -0.02, 1e-5, 1e-5, 0.0, 0.9, 0.1, 0.0)),
    colour=Lens(1280, 720, 612.1, 612.2, 640.0, 360.0),
    colour_from_depth=np.array(
        [[1, 0, 0, -32.0], [0, 0.8, 0.6, -2.0], [0, -0.6, 0.8, 4.0], [0, 0, 0, 1]]
    ),
)
DAY_US = 1_795_332_989_529_775
"""A moment of Unix time, as live frames carry it."""


def frames(count=4, start_us=463_945) -> list[Frame]:
    rng = np.random.default_rng(0)
    noise = [rng.integers(0, 65536, SHAPE, np.uint16) for _ in range(2)]
    return [
        Frame(start_us + n * 33_333, noise[0] + np.uint16(n), noise[1], b"\xff\xd8%d\xff\xd9" % n)
        for n in range(count)
    ]


def record(path: Path, of: list[Frame], *, colour=True, camera=CAMERA) -> None:
    with Recorder(path, camera, fps=30, colour=colour) as recorder:
        for frame in of:
            assert recorder.write(frame)


def play(path: Path) -> tuple[Camera, list[Frame]]:
    recording = Recording(path, realtime=False, loop=False)
    read = []
    try:
        while True:
            frame = recording.read(0)
            assert isinstance(frame, Frame)
            read.append(frame)
    except EndOfSource:
        return recording.camera, read
    finally:
        recording.close()


@pytest.mark.parametrize("start_us", [0, 463_945, DAY_US])
def test_frames_come_back_equal_and_times_to_a_millisecond(tmp_path, start_us):
    written = frames(start_us=start_us)
    record(tmp_path / "r.mkv", written)
    _, read = play(tmp_path / "r.mkv")
    for mine, theirs in zip(read, written, strict=True):
        np.testing.assert_array_equal(mine.depth, theirs.depth)
        np.testing.assert_array_equal(mine.ir, theirs.ir)
        assert mine.colour == theirs.colour
        assert abs(mine.time_us - theirs.time_us) <= 500


@pytest.mark.parametrize("colour", [True, False])
def test_the_camera_comes_back_equal(tmp_path, colour):
    record(tmp_path / "r.mkv", frames(), colour=colour)
    camera, _ = play(tmp_path / "r.mkv")
    assert (camera.serial, camera.depth_mode, camera.fps) == ("0123", "NFOV_2X2BINNED", 30)
    assert camera.depth == CAMERA.depth
    assert (camera.colour is not None) == colour
    if camera.colour is not None:
        np.testing.assert_allclose(camera.colour.matrix, CAMERA.colour.matrix, rtol=1e-12)
        np.testing.assert_allclose(camera.colour_from_depth, CAMERA.colour_from_depth, atol=1e-12)


def test_the_same_frames_give_the_same_bytes(tmp_path):
    record(tmp_path / "one.mkv", frames())
    record(tmp_path / "two.mkv", frames())
    assert (tmp_path / "one.mkv").read_bytes() == (tmp_path / "two.mkv").read_bytes()


def test_colour_as_an_array_becomes_a_jpeg_that_looks_the_same(tmp_path):
    ramp = np.linspace(0, 255, 1280, dtype=np.uint8)
    picture = np.repeat(ramp[None, :, None], 720, axis=0).repeat(3, axis=2)
    record(tmp_path / "r.mkv", [replace(f, colour=picture) for f in frames(2)])
    _, read = play(tmp_path / "r.mkv")
    assert isinstance(read[0].colour, bytes)
    decoded = cv2.imdecode(np.frombuffer(read[0].colour, np.uint8), cv2.IMREAD_COLOR)
    assert np.abs(decoded.astype(int) - picture).mean() < 2


def test_a_frame_without_colour_is_recorded_without_it(tmp_path):
    written = frames(3)
    written[1] = replace(written[1], colour=None)
    record(tmp_path / "r.mkv", written)
    _, read = play(tmp_path / "r.mkv")
    assert [f.colour is None for f in read] == [False, True, False]


def test_a_frame_from_the_past_is_not_written(tmp_path):
    first, second, *_ = frames()
    with Recorder(tmp_path / "r.mkv", CAMERA, fps=30, colour=False) as recorder:
        assert recorder.write(second)
        assert not recorder.write(second)
        assert not recorder.write(first)
    _, read = play(tmp_path / "r.mkv")
    assert len(read) == 1


def test_debian_s_ffmpeg_reads_the_same_frames(tmp_path):
    ffmpeg = shutil.which("ffmpeg")
    if ffmpeg is None:
        pytest.skip("ffmpeg is not installed")
    written = frames()
    record(tmp_path / "r.mkv", written)

    def decoded(track: int) -> np.ndarray:
        command = [ffmpeg, "-v", "error", "-i", str(tmp_path / "r.mkv"), "-map", f"0:{track}"]
        raw = [*command, "-f", "rawvideo", "-pix_fmt", "gray16le", "-"]
        done = subprocess.run(raw, capture_output=True, check=True)
        return np.frombuffer(done.stdout, "<u2").reshape(-1, *SHAPE)

    np.testing.assert_array_equal(decoded(1), [f.depth for f in written])
    np.testing.assert_array_equal(decoded(2), [f.ir for f in written])


def left_in(folder: Path) -> list[str]:
    return sorted(p.name for p in folder.iterdir())


def test_the_file_appears_only_when_complete(tmp_path):
    with Recorder(tmp_path / "r.mkv", CAMERA, fps=30, colour=False) as recorder:
        recorder.write(frames()[0])
        assert not (tmp_path / "r.mkv").exists()
    assert left_in(tmp_path) == ["r.mkv"]


def test_a_failed_run_does_not_change_the_old_recording(tmp_path):
    record(tmp_path / "r.mkv", frames())
    before = (tmp_path / "r.mkv").read_bytes()
    with (
        pytest.raises(RuntimeError, match="something else broke"),
        Recorder(tmp_path / "r.mkv", CAMERA, fps=30, colour=False) as recorder,
    ):
        recorder.write(frames()[0])
        raise RuntimeError("something else broke")
    assert left_in(tmp_path) == ["r.mkv"]
    assert (tmp_path / "r.mkv").read_bytes() == before


def test_a_recording_without_a_frame_is_deleted(tmp_path):
    recorder = Recorder(tmp_path / "r.mkv", CAMERA, fps=30, colour=False)
    with pytest.raises(UserError, match="no frame came"):
        recorder.close()
    recorder.close()
    recorder.abort()
    assert left_in(tmp_path) == []


@pytest.mark.parametrize(
    ("name", "says"),
    [("nowhere/r.mkv", r"the folder \S*nowhere does not exist; create it"), ("", "is a folder")],
)
def test_an_unwritable_path_is_refused_at_once(tmp_path, name, says):
    with pytest.raises(UserError, match=says):
        Recorder(tmp_path / name, CAMERA, fps=30, colour=False)


def test_frames_of_another_size_are_refused(tmp_path):
    with pytest.raises(ValueError, match="no colour"):
        Recorder(tmp_path / "r.mkv", replace(CAMERA, colour=None), fps=30, colour=True)
    recorder = Recorder(tmp_path / "r.mkv", CAMERA, fps=30, colour=True)
    good = frames()[0]
    for bad in (
        replace(good, depth=good.depth[:-1]),
        replace(good, ir=good.ir[:, :-1]),
        replace(good, colour=np.zeros((72, 128, 3), np.uint8)),
    ):
        with pytest.raises(ValueError, match="does not fit the camera"):
            recorder.write(bad)
    recorder.abort()
    assert left_in(tmp_path) == []


@pytest.mark.skipif(sys.platform == "win32", reason="no file size limits on Windows")
@pytest.mark.parametrize("limit", [1, 100_000, 900_000])
def test_a_full_disk_is_reported_and_leaves_no_file(tmp_path, limit):
    """The operating system refuses to let the file grow, as a full disk does."""
    script = f"""
        import resource, signal, sys
        sys.path.insert(0, {str(Path(__file__).parent)!r})
        from test_recorder import CAMERA, Path, Recorder, UserError, frames
        signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
        resource.setrlimit(resource.RLIMIT_FSIZE, ({limit}, {limit}))
        try:
            with Recorder(Path("r.mkv"), CAMERA, fps=30, colour=True) as recorder:
                for frame in frames(3):
                    recorder.write(frame)
        except UserError as error:
            print(error)
    """
    done = subprocess.run(
        [sys.executable, "-c", textwrap.dedent(script)],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=True,
    )
    assert "r.mkv cannot be written" in done.stdout
    assert done.stderr == ""
    assert left_in(tmp_path) == []


@pytest.mark.skipif(sys.platform == "win32", reason="links need rights on Windows")
def test_a_link_is_followed_and_stays_a_link(tmp_path):
    (tmp_path / "link.mkv").symlink_to(tmp_path / "r.mkv")
    record(tmp_path / "link.mkv", frames())
    assert (tmp_path / "link.mkv").is_symlink()
    assert len(play(tmp_path / "r.mkv")[1]) == len(frames())


@pytest.mark.skipif(sys.platform == "win32", reason="no FIFOs on Windows")
def test_a_pipe_is_refused_and_stays_a_pipe(tmp_path):
    os.mkfifo(tmp_path / "r.mkv")
    with pytest.raises(UserError, match="is a pipe or device"):
        Recorder(tmp_path / "r.mkv", CAMERA, fps=30, colour=False)
    assert (tmp_path / "r.mkv").is_fifo()
