"""EgoPressure's shards, in their published format, made here; the real files were never run."""

from __future__ import annotations

import json
import os
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest

from halo_service.app.cli import main
from halo_service.app.datasets.ego_pressure import (
    CELLS,
    COUNTS_PER_N,
    G_PER_N,
    PERIOD_US,
    SequenceRequest,
    forces_g,
    read_rig,
    truth,
)
from halo_service.errors import UserError
from halo_service.evaluation.metrics.truth import read_truth
from halo_service.geometry import k4a
from halo_service.geometry.camera import Camera, Lens
from halo_service.geometry.surface import Surface
from halo_service.sources.recording import Recording
from halo_service.values import Frame

HEIGHT_MM = 600.0
"""The camera looks straight down on the pad."""
COLOUR = Lens(2560, 1440, 1200.0, 1200.0, 1280.0, 720.0)
CAMERA = Camera(
    "000123", "WFOV_2X2BINNED", 30, Lens(512, 512, 252.0, 252.0, 256.0, 256.0), COLOUR, np.eye(4)
)
CAMERA.colour_from_depth[:3, 3] = (-32.0, 2.0, 4.0)
PRESSED = 3
"""The frame in which the index finger presses with 2 N."""
TIP_MM = (30.0, -20.0)


def arrow():
    try:
        import pyarrow
        import pyarrow.parquet
    except ImportError:
        if os.environ.get("HALO_CI"):
            pytest.fail("pyarrow is not installed, and .ci/run must install it")
        pytest.skip("pyarrow is not installed (--extra datasets)")
    return pyarrow


def joints(height_mm: float) -> list[float]:
    """(21, 3) m in the pad's frame, z down: the index tip at its place, the others away."""
    found = np.full((21, 3), (0.0, 0.06, -0.05))
    found[8] = (TIP_MM[0] / 1000.0, TIP_MM[1] / 1000.0, -height_mm / 1000.0)
    return found.ravel().tolist()


def pressure(newton: float) -> list[float]:
    counts = np.zeros(CELLS, np.float32)
    column = round((TIP_MM[0] + 120.0) / 240.0 * CELLS[1])
    row = round((TIP_MM[1] + 68.75) / 137.5 * CELLS[0])
    counts[row - 2 : row + 3, column - 2 : column + 3] = newton * COUNTS_PER_N / 25.0
    return counts.ravel().tolist()


@pytest.fixture
def download(tmp_path) -> Path:
    """Three frames of one sequence, in the layout of the data set."""
    pa = arrow()
    folder = tmp_path / "egopressure_data"
    shards = folder / "data" / "p_001" / "seq"
    configs = folder / "configs" / "p_001"
    (configs / "seq_k4a").mkdir(parents=True)
    shards.mkdir(parents=True)
    # The factory's colour lens is distorted; the images are not, and the config says so.
    distorted = replace(COLOUR, distortion=(0.4, -2.6, 1e-3, 0.0, 1.5, 0.3, -2.4, 1.4))
    factory = replace(CAMERA, colour=distorted)
    (configs / "seq_k4a" / "cam-4.k4a_calibration.json").write_bytes(k4a.to_json(factory))
    colour_from_pad = CAMERA.colour_from_depth @ np.array(
        [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, HEIGHT_MM], [0, 0, 0, 1.0]]
    )
    entry = {
        "fx": COLOUR.fx, "fy": COLOUR.fy, "cx": COLOUR.cx, "cy": COLOUR.cy,
        "ImageSizeX": 2560, "ImageSizeY": 1440, "SerialNo": "000123",
        "ModelViewMatrix": colour_from_pad.tolist(),
    }  # fmt: skip
    config = {"camera_calibrations": {"4": entry}}
    (configs / "seq.json").write_text(json.dumps(config))
    frames = [2, PRESSED, 4]
    depth = np.zeros((512, 512), np.uint16)
    depth[150:360, 130:380] = HEIGHT_MM
    png = cv2.imencode(".png", depth)[1].tobytes()
    jpg = cv2.imencode(".jpg", np.full((1440, 2560, 3), 90, np.uint8))[1].tobytes()

    def write(name: str, **columns: object) -> None:
        table = pa.table({"frame": pa.array(frames, pa.int64()), **columns})
        pa.parquet.write_table(table, shards / name, row_group_size=2)

    write("cam-4.depth.parquet", depth=[{"bytes": png, "path": "d"}] * 3)
    write("cam-4.color.parquet", image=[{"bytes": jpg, "path": "c"}] * 3)
    write("pressure.parquet", force=[pressure(0.0), pressure(2.0), pressure(0.0)])
    write(
        "annotation.parquet",
        has_annotation=[True, True, False],
        joint_position=[joints(8.0), joints(0.0), None],
        hand_side=["right"] * 3,
    )
    return folder


def test_truth_has_place_force_and_contact(download) -> None:
    request = SequenceRequest(download, "p_001", "seq", 4)
    rig = read_rig(request)
    lines = truth(request, rig)
    frames = {line["time_us"]: line["fingers"] for line in lines if "fingers" in line}
    assert list(frames) == [2 * PERIOD_US, 3 * PERIOD_US, 4 * PERIOD_US]
    index = {each["finger"]: each for each in frames[PRESSED * PERIOD_US]}["index"]
    np.testing.assert_allclose(index["camera_mm"], (*TIP_MM, HEIGHT_MM), atol=0.1)
    assert (index["hand"], index["touching"], index["height_mm"]) == ("right", True, 0.0)
    assert index["force_g"] == pytest.approx(2.0 * G_PER_N, rel=0.01)
    before = {each["finger"]: each for each in frames[2 * PERIOD_US]}["index"]
    assert (before["touching"], before["height_mm"], before["force_g"]) == (False, 8.0, 0.0)
    assert frames[4 * PERIOD_US] == [], "a frame without annotation says nothing of fingers"
    (contact,) = [line["contact"] for line in lines if "contact" in line]
    assert (contact["from_us"], contact["finger"]) == (PRESSED * PERIOD_US, "index")
    assert contact["peak_force_g"] == pytest.approx(204, abs=3)
    read = read_truth(lines, Surface("table", 300.0, 200.0, np.eye(4)))
    assert len(read.touches) == 1


def test_the_command_writes_a_recording_that_is_read_back(download, tmp_path, capsys) -> None:
    given = ["--data", str(download), "--participant", "p_001", "--sequence", "seq"]
    command = ["import-dataset", "ego-pressure", str(tmp_path / "out"), *given]
    assert main([*command, "--camera", "4"]) == 0
    recording, truth_file = capsys.readouterr().out.split()
    assert Path(truth_file).exists()
    source = Recording(Path(recording), realtime=False, loop=False)
    assert source.camera.depth_mode == "WFOV_2X2BINNED"
    assert source.camera.colour is not None
    np.testing.assert_allclose(source.camera.colour.distortion, 0.0)
    first = source.read(1.0)
    source.close()
    assert isinstance(first, Frame)
    assert first.time_us == pytest.approx(2 * PERIOD_US, abs=1000)
    assert first.depth[256, 256] == HEIGHT_MM
    assert first.ir[256, 256] == 90 * 16, "the colour's brightness is in place of infrared"
    assert first.ir[10, 10] == 0
    assert main([*command, "--camera", "5"]) == 2
    assert "calibration of camera 5 cannot be read" in capsys.readouterr().err


def test_forces_belong_to_the_nearest_finger_within_reach() -> None:
    counts = np.zeros(CELLS)
    counts[52, 92] = COUNTS_PER_N  # near the middle: 1 N
    counts[0, 0] = COUNTS_PER_N  # the palm at a corner
    tips_mm = np.array([[0.0, 0.0, 0.0], [10.0, 0.0, 0.0], [60.0, 0.0, 0.0]])
    np.testing.assert_allclose(forces_g(counts, tips_mm), [G_PER_N, 0.0, 0.0])


def test_a_broken_shard_is_one_sentence(download) -> None:
    request = SequenceRequest(download, "p_001", "seq", 4)
    rig = read_rig(request)
    (request.shards / "pressure.parquet").write_bytes(b"not parquet")
    with pytest.raises(UserError, match=r"pressure\.parquet cannot be read"):
        truth(request, rig)
