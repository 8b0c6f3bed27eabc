"""The real hand tracker on rendered hands, and on a real desk without any."""

import os
import subprocess
import sys
import zipfile
from pathlib import Path

import numpy as np
import pytest
from mediapipe.tasks.python.components.containers.landmark import NormalizedLandmark

from halo_service.errors import UserError
from halo_service.hand_tracking.blend import ColourWarp, blend
from halo_service.hand_tracking.hands import HandTracker, to_pixels
from halo_service.hand_tracking.model import hand_model
from halo_service.hand_tracking.quiet import without_known_noise
from halo_service.values import Side
from halo_service.virtual import offline
from halo_service.virtual.camera import factory
from halo_service.virtual.sim_url import parse_sim_url

DESK = Path(__file__).parents[2] / "../shared/data/azure_kinect_desk.mkv"
EYE_TO_TIP_PX = 12
"""From MediaPipe's landmark, which lies in the finger's middle, to the pad's lowest point."""


@pytest.fixture
def tracker():
    tracker = HandTracker(hand_model(None))
    yield tracker
    tracker.close()


def film(name: str, count: int = 12) -> list[tuple[int, np.ndarray, np.ndarray]]:
    """(time, picture, the index fingertip in pixels) of the first rendered frames with a hand."""
    camera = factory()
    warp = ColourWarp(camera, np.full((576, 640), 500, np.float32))
    shown = []
    for frame, lines in offline.frames(parse_sim_url(name), 6.0):
        fingers = [f for line in lines for f in line.get("fingers", ()) if f["finger"] == "index"]
        if frame is not None and fingers:
            tip = camera.depth.project(np.array([fingers[0]["camera_mm"]]))[0]
            picture = blend(frame.ir, frame.colour, warp, frame.depth)
            shown.append((frame.time_us, picture, tip))
        if len(shown) == count:
            break
    assert len(shown) == count
    return shown


@pytest.fixture(scope="module")
def right_hand():
    return film("demo")


def test_a_right_hand_palm_down_is_found_where_it_is_and_called_right(tracker, right_hand):
    for time_us, picture, tip in right_hand:
        tracked = tracker.find(picture, time_us)
        assert tracked.time_us == time_us
        (hand,) = tracked.hands
        assert hand.side is Side.RIGHT
        assert hand.confidence > 0.5
        assert hand.landmarks_px.shape == (21, 2)
        assert np.linalg.norm(hand.landmarks_px[8] - tip) < EYE_TO_TIP_PX


def test_a_left_hand_is_called_left(tracker):
    for time_us, picture, _ in film("demo?hand=left", 3):
        (hand,) = tracker.find(picture, time_us).hands
        assert hand.side is Side.LEFT


def test_the_same_video_gives_the_same_hands(right_hand):
    runs = []
    for _ in range(2):
        tracker = HandTracker(hand_model(None))
        runs.append([tracker.find(picture, time_us) for time_us, picture, _ in right_hand])
        tracker.close()
    for one, other in zip(*runs, strict=True):
        for mine, theirs in zip(one.hands, other.hands, strict=True):
            np.testing.assert_array_equal(mine.landmarks_px, theirs.landmarks_px)
            assert (mine.side, mine.confidence) == (theirs.side, theirs.confidence)


TIMES = {
    "standing still": [5_000_000] * 6,
    "running backwards": [9_000_000 - 33_333 * n for n in range(6)],
    "jumping back to the start": [7_200_000_000, 7_200_033_333, 0, 33_333, 66_666, 99_999],
    "jumping to Unix time": [0, 33_333, 1_795_332_989_529_775, 1_795_332_989_563_108, 0, 1],
    "before zero": [-99_999, -66_666, -33_333, 0, 33_333, 66_666],
    "closer than a millisecond": list(range(6)),
}


@pytest.mark.parametrize("times", TIMES.values(), ids=TIMES)
def test_whatever_time_does_hands_are_found(tracker, right_hand, times):
    for time_us, (_, picture, _) in zip(times, right_hand, strict=False):
        tracked = tracker.find(picture, time_us)
        assert tracked.time_us == time_us
        assert len(tracked.hands) == 1


@pytest.mark.parametrize(
    ("relative", "px"),
    [((0, 0), (-0.5, -0.5)), ((1, 1), (639.5, 575.5)), ((0.5 / 640, 1.5 / 576), (0, 1))],
)
def test_landmarks_count_pixels_from_the_centre_of_the_first(relative, px):
    mark = NormalizedLandmark(x=relative[0], y=relative[1], z=0.0)
    np.testing.assert_allclose(to_pixels([mark], 640, 576), [px], atol=1e-9)


def test_a_real_desk_without_a_hand_has_none(tracker):
    if not DESK.exists():
        pytest.skip("no shared/data/azure_kinect_desk.mkv")
    from halo_service.sources.recording import Recording

    recording = Recording(DESK, realtime=False, loop=False)
    frame = recording.read(0)
    recording.close()
    warp = ColourWarp(recording.camera, np.full((576, 640), 500, np.float32))
    for n in range(3):
        picture = blend(frame.ir, frame.colour, warp, frame.depth)
        assert tracker.find(picture, n * 33_333).hands == ()


def a_foreign_zip(path: Path) -> None:
    with zipfile.ZipFile(path, "w") as bundle:
        bundle.writestr("readme.txt", "no network in here")


NO_MODELS = {
    "rubbish": lambda path: path.write_bytes(b"PK\x03\x04 not a model"),
    "a zip of something else": a_foreign_zip,
    "nothing": lambda path: None,
}


@pytest.mark.parametrize("write", NO_MODELS.values(), ids=NO_MODELS)
def test_a_file_that_is_not_a_model_is_refused_in_one_line(tmp_path, write):
    path = tmp_path / "own.task"
    write(path)
    with pytest.raises(UserError, match=r"own\.task cannot be loaded") as caught:
        HandTracker(path)
    assert "\n" not in str(caught.value)


def test_a_bad_number_of_hands_is_not_reported_as_a_bad_model():
    with pytest.raises(ValueError, match="max_hands must be 1 or more, not 0"):
        HandTracker(hand_model(None), max_hands=0)


def test_starting_prints_nothing_on_the_terminal():
    script = (
        "from halo_service.hand_tracking.hands import HandTracker\n"
        "from halo_service.hand_tracking.model import hand_model\n"
        "HandTracker(hand_model(None)).close()\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, check=True
    )
    assert (done.stdout, done.stderr) == ("", "")


def test_what_is_not_known_noise_is_printed_even_after_an_error(capfd):
    with pytest.raises(RuntimeError, match="it broke"), without_known_noise():
        os.write(2, b"INFO: Created TensorFlow Lite XNNPACK delegate for CPU.\nit burns\n")
        raise RuntimeError("it broke")
    os.write(2, b"afterwards\n")
    assert capfd.readouterr().err == "it burns\nafterwards\n"
