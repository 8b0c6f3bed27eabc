"""Labels of DepthTouchSensing, in their published format, on a recording made here.

The real videos were never run. The labels of a few real sessions are read where they are shared.
"""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from halo_service.app.cli import main
from halo_service.app.datasets.depth_touch import Placement, convert
from halo_service.errors import UserError
from halo_service.evaluation.metrics.truth import read_truth
from halo_service.geometry.camera import Camera, Lens
from halo_service.geometry.surface import Surface
from halo_service.outputs.recorder import Recorder
from halo_service.sources.recording import Recording
from halo_service.values import Frame
from halo_service.virtual.scenarios.labels import raw_touches

CAMERA = Camera(
    "0123", "NFOV_2X2BINNED", 30, Lens(320, 288, 252.0, 252.0, 160.0, 144.0), None, np.eye(4)
)
PLANE = (0.2, -0.1, 600.0)
"""z = 0.2 x - 0.1 y + 600: the tablet is tilted."""
LABELS = (
    "7,touchdown,100,200,1000000\r\r\n"
    "7,touchmove,110,210,1000100\r\r\n"
    "7,touchend,0,0,1000200\r\r\n"
    "8,touchdown,900,700,1000400\r\r\n"  # it never ends
    "8,touchmove,910,700,1000450\r\r\n"
    "not a line\r\r\n"
)


def on_plane(px: np.ndarray) -> np.ndarray:
    """(N, 3) mm where the rays of pixels meet the plane."""
    rays = CAMERA.depth.rays(np.asarray(px, np.float64))
    a, b, c = PLANE
    return rays * (c / (1.0 - a * rays[:, 0] - b * rays[:, 1]))[:, None]


def screen() -> np.ndarray:
    """(4, 3) mm: the corners of a screen of 240 x 180 mm on the plane, a little turned."""
    normal = np.array([-PLANE[0], -PLANE[1], 1.0])
    right = np.cross(np.cross(normal, (1.0, 0.1, 0.0)), normal)
    down = np.cross(normal, right)
    corner = on_plane(np.array([[100.0, 100.0]]))[0]
    right, down = 240.0 * right / np.linalg.norm(right), 180.0 * down / np.linalg.norm(down)
    return np.array([corner, corner + right, corner + right + down, corner + down])


CORNERS_PX = tuple(map(tuple, CAMERA.depth.project(screen()).tolist()))


@pytest.fixture(scope="module")
def video(tmp_path_factory) -> Path:
    rows, columns = np.mgrid[0:288, 0:320]
    px = np.column_stack([columns.ravel(), rows.ravel()]).astype(np.float64)
    depth = np.rint(on_plane(px)[:, 2]).reshape(288, 320).astype(np.uint16)
    depth[::3, ::3] = 0  # a screen has holes
    path = tmp_path_factory.mktemp("video") / "1_1.mkv"
    with Recorder(path, CAMERA, fps=30, colour=False) as recorder:
        for number in range(60):
            recorder.write(Frame(463_000 + number * 33_333, depth, depth))
    return path


@pytest.fixture
def labels(tmp_path) -> Path:
    path = tmp_path / "1_1.txt"
    path.write_bytes(LABELS.encode())
    return path


def lines_of(video: Path, labels: Path, first_touch_s: float = 0.5):
    source = Recording(video, realtime=False, loop=False)
    try:
        return convert(source, labels, Placement(CORNERS_PX, (1024, 768), first_touch_s))
    finally:
        source.close()


def test_contacts_are_where_and_when_the_labels_say(video, labels) -> None:
    lines = lines_of(video, labels)
    first, second = (line["contact"] for line in lines if "contact" in line)
    start_us = lines[0]["time_us"]
    assert first["from_us"] - start_us == pytest.approx(500_000, abs=34_000)
    assert first["to_us"] - first["from_us"] == pytest.approx(200_000, abs=67_000)
    assert second["from_us"] - start_us == pytest.approx(900_000, abs=34_000)
    for contact, share in ((first, (100 / 1024, 200 / 768)), (second, (900 / 1024, 700 / 768))):
        (u, v), (corner, right, _, down) = share, screen()
        expected = corner + u * (right - corner) + v * (down - corner)
        np.testing.assert_allclose(contact["camera_mm"], expected, atol=1.5)
        x, y, z = contact["camera_mm"]
        assert z == pytest.approx(PLANE[0] * x + PLANE[1] * y + PLANE[2], abs=1.5)


def test_the_evaluation_reads_the_truth(video, labels) -> None:
    truth = read_truth(lines_of(video, labels), Surface("table", 300.0, 200.0, np.eye(4)))
    assert len(truth.frames) == 60
    assert [touch.frames > 1 for touch in truth.touches] == [True, True]
    touching = [frame for frame in truth.frames if frame.fingers]
    assert 7 <= len(touching) <= 11


def test_the_command_writes_the_truth(video, labels, tmp_path, capsys) -> None:
    corners = ",".join(f"{each:g}" for corner in CORNERS_PX for each in corner)
    given = ["--video", str(video), "--labels", str(labels), "--corners", corners]
    out = ["import-dataset", "depth-touch", str(tmp_path / "04-1_1"), *given]
    assert main([*out, "--first-touch-s", "0.5"]) == 0
    path = Path(capsys.readouterr().out.strip())
    assert path == tmp_path / "04-1_1.truth.jsonl"
    assert sum("contact" in json.loads(line) for line in path.read_text().splitlines()) == 2
    assert main(out) == 2
    assert "give --first-touch-s" in capsys.readouterr().err
    assert main([*out, "--first-touch-s", "0.5", "--corners", "1,2,3"]) == 2
    assert "--corners needs 8 numbers" in capsys.readouterr().err


def test_a_corner_beside_the_screen_is_one_sentence(video, labels) -> None:
    source = Recording(video, realtime=False, loop=False)
    outside = (*CORNERS_PX[:3], (-50.0, -50.0))
    with pytest.raises(UserError, match="no depth around a corner"):
        convert(source, labels, Placement(outside, (1024, 768), 0.5))
    source.close()


def test_labels_of_real_sessions_are_read(company_data) -> None:
    files = sorted((company_data / "touch_labels").glob("*.txt"))
    if not files:
        pytest.skip("no shared/data/touch_labels")
    for file in files:
        ways = raw_touches(file)
        assert len(ways) > 10, file
        assert all(0.0 <= event.x <= 1024.0 and event.y <= 768.0 for way in ways for event in way)
