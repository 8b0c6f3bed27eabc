"""Reading recordings: the real one as the SDK reads it, ours as written, bad ones refused."""

import time
from pathlib import Path

import numpy as np
import pytest

from halo_service.errors import UserError
from halo_service.sources import EndOfSource
from halo_service.sources.recording import Pace, Recording
from halo_service.values import BadFrame, Frame

REAL = Path(__file__).parents[2] / "../shared/data/azure_kinect_desk.mkv"
real_file = pytest.mark.skipif(not REAL.exists(), reason="no shared/data/azure_kinect_desk.mkv")
PERIOD_US = 33_333


def play(path: Path, *, laps_of: int | None = None) -> list[Frame | BadFrame]:
    """Everything in the file, or in its first `laps_of` captures when it loops."""
    recording = Recording(path, realtime=False, loop=laps_of is not None)
    captures = []
    try:
        while laps_of is None or len(captures) < laps_of:
            capture = recording.read(0)
            assert capture is not None
            captures.append(capture)
    except EndOfSource:
        pass
    finally:
        recording.close()
    return captures


@real_file
def test_a_real_recording_has_the_pixels_that_the_sdk_reads():
    pyk4a = pytest.importorskip("pyk4a", reason="the Azure Kinect SDK is not installed")
    (frame,) = play(REAL)
    assert isinstance(frame, Frame)
    with pyk4a.PyK4APlayback(REAL) as playback:
        capture = playback.get_next_capture()
        np.testing.assert_array_equal(frame.depth, capture.depth)
        np.testing.assert_array_equal(frame.ir, capture.ir)
        assert frame.colour == capture.color.tobytes()
        start_us = playback.configuration["start_timestamp_offset_usec"]
        assert frame.time_us == capture.depth_timestamp_usec - start_us
    assert frame.depth.dtype == frame.ir.dtype == np.uint16
    assert frame.depth.shape == (576, 640)


@real_file
def test_a_real_recording_brings_its_camera():
    recording = Recording(REAL, realtime=False, loop=False)
    recording.close()
    camera = recording.camera
    assert (camera.serial, camera.depth_mode, camera.fps) == ("001514394512", "NFOV_UNBINNED", 5)
    assert camera.colour is not None
    assert (camera.colour.width, camera.colour.height) == (1280, 720)


@real_file
def test_a_real_recording_cut_anywhere_is_refused_at_once(tmp_path):
    data = REAL.read_bytes()
    path = tmp_path / "cut.mkv"
    outcomes = set()
    for length in [*range(4, 9000, 301), *range(9000, len(data), 40_009), len(data) - 1]:
        path.write_bytes(data[:length])
        outcomes.add(outcome_of(path))
    assert outcomes == {(0, "header is cut off"), (0, "is truncated:")}


def outcome_of(path: Path) -> tuple[int, str]:
    """How many frames came, and the last error."""
    frames = 0
    try:
        recording = Recording(path, realtime=False, loop=False)
        try:
            while True:
                frames += isinstance(recording.read(0), Frame)
        finally:
            recording.close()
    except EndOfSource:
        return frames, "a normal end"
    except UserError as error:
        known = ("header is cut off", "is truncated:", "never closed, and ends after")
        said = next((words for words in known if words in str(error)), str(error))
        return frames, f"{said} {frames}" if said == known[2] else said


def test_our_own_recording_cut_anywhere_is_refused_at_once(tmp_path, small_recording):
    data = small_recording.read_bytes()
    path = tmp_path / "cut.mkv"
    for length in [*range(4, len(data), 9001), len(data) - 1]:
        path.write_bytes(data[:length])
        assert outcome_of(path) in ((0, "header is cut off"), (0, "is truncated:")), length


def test_a_truncated_recording_is_refused_when_it_is_opened(tmp_path, small_recording):
    path = tmp_path / "cut.mkv"
    path.write_bytes(small_recording.read_bytes()[:-1])
    with pytest.raises(UserError, match=r"cut\.mkv is truncated: it has \d+ of its \d+ bytes"):
        Recording(path, realtime=False, loop=False)


def test_a_recording_that_was_never_closed_is_reported_at_its_end(tmp_path, small_recording):
    data = bytearray(small_recording.read_bytes())
    segment = data.index(b"\x18\x53\x80\x67")
    data[segment + 4 : segment + 12] = b"\x01" + b"\xff" * 7  # the size, still unknown
    path = tmp_path / "unclosed.mkv"
    path.write_bytes(data)
    assert outcome_of(path) == (6, "never closed, and ends after 6")


def test_ours_reads_back_as_it_was_written(small_recording, small_frames):
    for read, written in zip(play(small_recording), small_frames, strict=True):
        assert isinstance(read, Frame)
        np.testing.assert_array_equal(read.depth, written.depth)
        np.testing.assert_array_equal(read.ir, written.ir)
        assert read.colour == written.colour
        assert abs(read.time_us - written.time_us) <= 500


def test_the_sdk_s_raw_images_are_read_from_more_than_one_frame(foreign):
    frames = play(foreign(codec="rawvideo", pix_fmt="gray16be"))
    assert [(f.time_us, f.depth[0, 5], f.ir[0, 5]) for f in frames] == [
        (0, 5, 5),
        (33_000, 38, 38),
        (66_000, 71, 71),
    ]
    assert all(f.colour is None and f.depth.flags.writeable for f in frames)


@pytest.mark.parametrize("colour", ["NV12", "YUY2", "BGRA"])
def test_colour_that_is_no_jpeg_comes_as_an_array(foreign, colour):
    frames = play(foreign(tracks=(colour, "DEPTH", "IR")))
    assert len(frames) == 3
    for frame in frames:
        assert isinstance(frame.colour, np.ndarray)
        assert (frame.colour.shape, frame.colour.dtype) == ((720, 1280, 3), np.uint8)
        assert frame.colour.std() > 10


FOREIGN = {
    "no depth": ({"tracks": ("COLOR", "IR")}, "has no DEPTH track"),
    "no IR": ({"tracks": ("COLOR", "DEPTH")}, "has no IR track"),
    "a film": (
        {"tracks": ("film",), "codec": "mjpeg", "pix_fmt": "yuvj420p"},
        "has no DEPTH track",
    ),
    "8-bit depth": ({"codec": "rawvideo", "pix_fmt": "gray"}, "DEPTH track is gray, not 16-bit"),
    "no calibration": ({"calibration": None}, "no calibration.json attached"),
    "not a calibration": ({"calibration": b"{}"}, "CalibrationInformation"),
    "no mode": ({"depth_mode": ""}, "unknown depth mode ''"),
    "IR only": ({"depth_mode": "PASSIVE_IR"}, "recorded in PASSIVE_IR, without depth"),
    "passive IR": (
        {"tracks": ("IR",), "depth_mode": "PASSIVE_IR"},
        "has no DEPTH track.*with depth and IR switched on",
    ),
    "another size": ({"size": (320, 240)}, "320 x 240 where its mode has 320 x 288"),
}


@pytest.mark.parametrize(("made", "says"), FOREIGN.values(), ids=FOREIGN)
def test_a_recording_without_what_we_need_is_refused_by_its_name(foreign, made, says):
    path = foreign(**made)
    with pytest.raises(UserError, match=says) as caught:
        Recording(path, realtime=False, loop=False)
    assert str(path) in str(caught.value)


NO_MATROSKA = {
    "empty": (b"", "is empty: copy or record it again"),
    "text": (b"hello\n" * 100, "is not a Matroska file"),
    "a picture": (b"\xff\xd8\xff\xe0" + bytes(5000), "is not a Matroska file"),
    "an mp4": (b"\0\0\0\x20ftypisom" + bytes(5000), "is not a Matroska file"),
    "a pointer": (
        b"version https://git-lfs.github.com/spec/v1\noid sha256:4d7a\nsize 91\n",
        "is a Git LFS pointer .* run 'git lfs pull'",
    ),
    "a web page": (b"\n<!DOCTYPE html><html>...", "is a web page and not a recording"),
}


@pytest.mark.parametrize(("content", "says"), NO_MATROSKA.values(), ids=NO_MATROSKA)
def test_a_file_of_another_kind_is_refused(tmp_path, content, says):
    path = tmp_path / "other.mkv"
    path.write_bytes(content)
    with pytest.raises(UserError, match=says):
        Recording(path, realtime=False, loop=False)


def test_a_missing_file_and_a_folder_have_different_errors(tmp_path):
    with pytest.raises(UserError, match="does not exist"):
        Recording(tmp_path / "nowhere.mkv", realtime=False, loop=False)
    with pytest.raises(UserError, match="is a folder"):
        Recording(tmp_path, realtime=False, loop=False)


@pytest.mark.parametrize("start_ms", [0, 95_000, 90 * 60_000, 40 * 365 * 86_400_000, -5_000])
def test_time_may_start_anywhere(foreign, start_ms):
    times_ms = (start_ms, start_ms + 33, start_ms + 66)
    frames = play(foreign(times_ms=times_ms))
    assert np.diff([frame.time_us for frame in frames]).tolist() == [33_000, 33_000]
    assert all(isinstance(frame, Frame) for frame in frames)


BAD_CAPTURES = {
    "no depth packet": ({"missing": [("DEPTH", 33)]}, "no depth in this capture"),
    "no IR packet": ({"missing": [("IR", 33)]}, "no IR in this capture"),
    "spoilt depth": ({"spoilt": [("DEPTH", 33)]}, "the depth cannot be decoded"),
    "spoilt IR": ({"spoilt": [("IR", 33)]}, "the IR cannot be decoded"),
    "spoilt raw depth": (
        {"spoilt": [("DEPTH", 33)], "codec": "rawvideo", "pix_fmt": "gray16be"},
        "the depth cannot be decoded",
    ),
}


@pytest.mark.parametrize(("made", "reason"), BAD_CAPTURES.values(), ids=BAD_CAPTURES)
def test_a_capture_that_lacks_something_is_a_bad_frame_among_good_ones(foreign, made, reason):
    first, bad, last = play(foreign(**made))
    assert bad == BadFrame(33_000, reason)
    assert isinstance(first, Frame)
    assert isinstance(last, Frame)


def test_a_recording_of_bad_frames_alone_is_refused(foreign):
    path = foreign(missing=[("IR", 0), ("IR", 33), ("DEPTH", 66)])
    with pytest.raises(UserError, match="no readable frame"):
        Recording(path, realtime=False, loop=False)


def test_damaged_bytes_never_end_in_a_traceback(tmp_path, small_recording):
    data = small_recording.read_bytes()
    path = tmp_path / "rubbish.mkv"
    for start in range(4, len(data) - 400, 30_011):
        path.write_bytes(data[:start] + b"\xaa" * 400 + data[start + 400 :])
        outcome_of(path)  # any error is a UserError


def test_in_a_loop_time_goes_on_rising_by_the_frame_period(small_recording, small_frames):
    captures = play(small_recording, laps_of=20)
    steps = np.diff([c.time_us for c in captures])
    np.testing.assert_allclose(steps, PERIOD_US, atol=1001)
    np.testing.assert_array_equal(captures[6].depth, small_frames[0].depth)


def test_without_a_loop_time_is_the_file_s_own(small_recording, small_frames):
    assert play(small_recording)[0].time_us == small_frames[0].time_us


def test_live_frames_come_when_they_are_due_in_unix_time(small_recording):
    recording = Recording(small_recording, realtime=True, loop=True)
    started = time.monotonic()
    arrivals = []
    while len(arrivals) < 8:
        capture = recording.read(timeout_s=1)
        assert capture is not None
        arrivals.append((time.time_ns() // 1000, capture.time_us))
    recording.close()
    # Never early; how late depends on the machine.
    assert time.monotonic() - started >= 7 * 0.033
    assert all(now_us >= time_us for now_us, time_us in arrivals)
    np.testing.assert_allclose(np.diff([t for _, t in arrivals]), PERIOD_US, atol=1001)


def test_live_nothing_comes_before_its_time(small_recording):
    recording = Recording(small_recording, realtime=True, loop=False)
    assert isinstance(recording.read(timeout_s=0), Frame)
    nothing = 0
    for _ in range(200):
        capture = recording.read(timeout_s=0.001)
        nothing += capture is None
        assert capture is None or capture.time_us <= time.time_ns() // 1000
        if nothing > 5:
            break
    assert nothing > 0
    recording.close()


def test_closing_twice_is_fine(small_recording):
    recording = Recording(small_recording, realtime=False, loop=False)
    recording.close()
    recording.close()


@pytest.mark.parametrize(
    ("starts_us", "read_ms", "longest_gap_ms"),
    [(0, 5, 34), (90_000_000, 5, 34), (-70_000_000, 5, 34), (0, 60, 61), (0, 400, 401)],
    ids=["at 0", "at 90 s", "below 0", "a slow machine", "a very slow machine"],
)
def test_on_a_slow_machine_a_recording_runs_slower_and_its_time_never_leaps(
    starts_us: int, read_ms: int, longest_gap_ms: int
) -> None:
    now_us, shown_us = 1_790_000_000_000_000, []
    pace = Pace(lambda: now_us)
    for n in range(200):
        now_us += read_ms * 1000  # reading, decoding and sensing
        due_us = pace.due_us(starts_us + n * 33_333)
        now_us = max(now_us, due_us)
        shown_us.append(due_us)
        assert now_us - due_us <= 300_000
    gaps_ms = np.diff(shown_us) / 1000
    assert gaps_ms.min() > 33.0
    assert np.percentile(gaps_ms[50:], 95) <= longest_gap_ms
    assert gaps_ms.max() < 1000.0


def test_after_a_long_pause_a_recording_continues_from_now() -> None:
    now_us = 1_790_000_000_000_000
    pace = Pace(lambda: now_us)
    before_us = pace.due_us(0)
    now_us += 10_000_000
    assert pace.due_us(33_333) - before_us == pytest.approx(10_000_000, abs=300_000)
