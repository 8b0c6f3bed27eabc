"""The factory calibration: read as the SDK reads it, written as the SDK reads it."""

import json
from pathlib import Path

import numpy as np
import pytest

from halo_service.geometry import k4a

SHARED = Path(__file__).parents[2] / "../shared/data"
REAL = SHARED / "azure_kinect_calibration.json"
real_file = pytest.mark.skipif(not REAL.exists(), reason="no shared/data/azure_kinect_calibration")


def parameters(cx, cy, fx, fy):
    return [cx, cy, fx, fy, 0.5, -0.02, -0.003, 0.9, 0.08, -0.01, 0, 0, -7e-5, 2e-5]


def entry(location, numbers, rotation, translation):
    return {
        "Location": location,
        "Intrinsics": {
            "ModelParameters": numbers,
            "ModelType": "CALIBRATION_LensDistortionModelBrownConrady",
        },
        "Rt": {"Rotation": rotation, "Translation": translation},
    }


def small() -> dict:
    """A device with round numbers: the minimum that a calibration must hold."""
    level = [1.0, 0, 0, 0, 1, 0, 0, 0, 1]
    return {
        "CalibrationInformation": {
            "Cameras": [
                entry(
                    "CALIBRATION_CameraLocationD0", parameters(0.5, 0.5, 0.5, 0.5), level, [0, 0, 0]
                ),
                entry(
                    "CALIBRATION_CameraLocationPV0",
                    parameters(0.5, 0.5, 0.48, 0.64),
                    [1, 0, 0, 0, 0.8, 0.6, 0, -0.6, 0.8],
                    [-0.032, -0.002, 0.004],
                ),
            ],
            "Metadata": {"SerialId": "0123"},
        }
    }


def read(content: dict | bytes, mode="NFOV_UNBINNED", colour: str | None = "720P"):
    data = content if isinstance(content, bytes) else json.dumps(content).encode()
    return k4a.from_json(data, depth_mode=mode, colour_resolution=colour, fps=30)


def assert_same(one: k4a.Camera, other: k4a.Camera) -> None:
    assert (one.serial, one.depth_mode, one.fps) == (other.serial, other.depth_mode, other.fps)
    assert (one.colour is None) == (other.colour is None)
    for mine, theirs in ((one.depth, other.depth), (one.colour, other.colour)):
        if mine is not None and theirs is not None:
            assert (mine.width, mine.height) == (theirs.width, theirs.height)
            np.testing.assert_allclose(mine.matrix, theirs.matrix, rtol=0, atol=1e-9)
            assert mine.distortion == theirs.distortion
    np.testing.assert_allclose(one.colour_from_depth, other.colour_from_depth, rtol=0, atol=1e-12)


def test_a_mode_cuts_and_scales_the_sensor():
    camera = read(small())
    assert (camera.depth.width, camera.depth.height) == (640, 576)
    # Half of 1024, less the crop's (192, 180), less the half pixel from corner to centre.
    assert (camera.depth.cx, camera.depth.cy) == (319.5, 331.5)
    assert (camera.depth.fx, camera.depth.fy) == (512, 512)
    assert camera.colour is not None
    assert (camera.colour.cx, camera.colour.cy) == (639.5, 359.5)
    assert camera.serial == "0123"


def test_lengths_become_millimetres():
    np.testing.assert_allclose(read(small()).colour_from_depth[:3, 3], [-32, -2, 4])


def test_without_colour_there_is_no_pose_of_it():
    camera = read(small(), colour=None)
    assert camera.colour is None
    np.testing.assert_array_equal(camera.colour_from_depth, np.eye(4))


@pytest.mark.parametrize("colour", [*k4a.COLOUR_RESOLUTIONS, None])
@pytest.mark.parametrize("mode", k4a.DEPTH_MODES)
def test_what_is_written_reads_back_to_the_same_camera(mode, colour):
    camera = read(small(), mode, colour)
    assert_same(read(k4a.to_json(camera), mode, colour), camera)
    assert k4a.to_json(camera) == k4a.to_json(camera)


@real_file
@pytest.mark.parametrize("colour", k4a.COLOUR_RESOLUTIONS)
@pytest.mark.parametrize("mode", k4a.DEPTH_MODES)
def test_a_real_device_has_the_lenses_that_the_sdk_gives_it(mode, colour):
    assert_as_the_sdk(read(REAL.read_bytes(), mode, colour), REAL.read_text(), mode, colour)


@real_file
def test_the_sdk_reads_our_file_as_it_reads_the_device_s_own():
    camera = read(REAL.read_bytes())
    ours = json.loads(k4a.to_json(camera))
    # The SDK requires the motion sensors; we do not know them and invent none.
    device = json.loads(REAL.read_text())["CalibrationInformation"]
    ours["CalibrationInformation"]["InertialSensors"] = device["InertialSensors"]
    assert_as_the_sdk(camera, json.dumps(ours), "NFOV_UNBINNED", "720P")


def assert_as_the_sdk(camera: k4a.Camera, raw: str, mode: str, colour: str) -> None:
    pyk4a = pytest.importorskip("pyk4a", reason="the Azure Kinect SDK is not installed")
    depth_kind, colour_kind = pyk4a.CalibrationType.DEPTH, pyk4a.CalibrationType.COLOR
    sdk = pyk4a.Calibration.from_raw(
        raw, pyk4a.DepthMode[mode], pyk4a.ColorResolution[f"RES_{colour}"]
    )
    assert camera.colour is not None
    for lens, kind in ((camera.depth, depth_kind), (camera.colour, colour_kind)):
        # The SDK computes in 32-bit floats: 7 digits.
        np.testing.assert_allclose(lens.matrix, sdk.get_camera_matrix(kind), rtol=2e-7)
        distortion = sdk.get_distortion_coefficients(kind)
        np.testing.assert_allclose(lens.distortion, distortion, rtol=2e-7)
    rotation, translation_m = sdk.get_extrinsic_parameters(depth_kind, colour_kind)
    np.testing.assert_allclose(camera.colour_from_depth[:3, :3], rotation, atol=1e-6)
    np.testing.assert_allclose(camera.colour_from_depth[:3, 3], translation_m[0] * 1000, rtol=1e-6)


def broken(*path: str | int, value: object = None) -> dict:
    """The small calibration with one thing removed or replaced."""
    content = small()
    parent: dict = content["CalibrationInformation"]
    for key in path[:-1]:
        parent = parent[key]
    if value is None:
        del parent[path[-1]]
    else:
        parent[path[-1]] = value
    return content


BAD = {
    "no bytes": (b"", "not JSON"),
    "text": (b"hello", "not JSON"),
    "not UTF-8": (b'{"a": "\xff"}', "not JSON"),
    "bottomless": (b"[" * 200_000, "not JSON"),
    "a list": (b"[]", "not a JSON object"),
    "something else": (b"{}", "CalibrationInformation"),
    "no cameras": (broken("Cameras"), "Cameras"),
    "cameras of another kind": (broken("Cameras", value=["?"]), "LocationD0"),
    "no colour camera": (broken("Cameras", 1), "LocationPV0"),
    "no serial": (broken("Metadata", "SerialId"), "SerialId"),
    "a serial that is a number": (broken("Metadata", "SerialId", value=7), "SerialId"),
    "no pose": (broken("Cameras", 0, "Rt"), "Rt"),
    "a flat pose": (broken("Cameras", 1, "Rt", "Rotation", value=[0] * 9), "rotation"),
    "few numbers": (
        broken("Cameras", 0, "Intrinsics", "ModelParameters", value=[1.0]),
        "1 numbers, not 14",
    ),
    "a word among numbers": (
        broken("Cameras", 0, "Intrinsics", "ModelParameters", value=["x"] * 14),
        "is not a number",
    ),
    "not finite": (
        broken("Cameras", 0, "Intrinsics", "ModelParameters", value=[float("nan")] * 14),
        "out of range",
    ),
    "huge": (
        broken("Cameras", 0, "Intrinsics", "ModelParameters", value=[10**400] * 14),
        "out of range",
    ),
    "no focal length": (
        broken("Cameras", 0, "Intrinsics", "ModelParameters", value=[0.0] * 14),
        "focal length",
    ),
    "another lens": (
        broken("Cameras", 0, "Intrinsics", "ModelType", value="fisheye"),
        "lens model 'fisheye'",
    ),
}


@pytest.mark.parametrize(("content", "message"), BAD.values(), ids=BAD)
def test_a_bad_file_is_refused_with_what_is_wrong(content, message):
    with pytest.raises(k4a.CalibrationError, match=message):
        read(content)


def test_every_truncation_is_refused():
    whole = json.dumps(small()).encode()
    for length in range(len(whole)):
        with pytest.raises(k4a.CalibrationError):
            read(whole[:length])


def test_every_depth_mode_has_a_rate():
    assert set(k4a.DEPTH_FPS) == set(k4a.DEPTH_MODES)


def test_the_sdk_s_trailing_nul_is_accepted():
    assert_same(read(json.dumps(small()).encode() + b"\0"), read(small()))


@pytest.mark.parametrize(
    ("mode", "colour", "message"),
    [("PASSIVE_IR", "720P", "depth mode 'PASSIVE_IR'"), ("NFOV_UNBINNED", "8K", "resolution '8K'")],
)
def test_an_unknown_mode_is_refused_with_the_choices(mode, colour, message):
    with pytest.raises(k4a.CalibrationError, match=f"{message}; choose from: "):
        read(small(), mode, colour)
