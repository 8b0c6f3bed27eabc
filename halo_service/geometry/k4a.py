"""The Azure Kinect's factory calibration: `calibration.json` to `Camera`, and back.

Rule: bytes in, values out, no I/O. The file describes the whole sensors in numbers
relative to their size; a depth mode or a colour resolution is a binned or scaled cut of
one, and gets the lens that belongs to that cut, as the SDK does it. Lengths are metres in
the file and mm here; the file's pixels have (0, 0) at the corner, ours at the centre.
"""

from __future__ import annotations

import json
from dataclasses import dataclass
from typing import Any, TypeVar

import numpy as np

from halo_service.errors import UserError
from halo_service.geometry.camera import Camera, Lens, Points

_T = TypeVar("_T")


class CalibrationError(UserError):
    """The bytes are not an Azure Kinect's calibration. The message says what is missing."""


@dataclass(frozen=True, slots=True)
class Cut:
    """The part of a sensor that a mode shows."""

    scaled: tuple[int, int]
    """Width and height of the whole sensor after binning or scaling, px."""
    offset: tuple[int, int]
    """The image's top left pixel in it, px."""
    size: tuple[int, int]
    """Width and height of the image, px."""


# Modes and sizes: the Azure Kinect's published hardware specification. Offsets: the sensor
# is 1024 x 1024 (depth) and 4096 x 3072 (colour); tests compare every cut with the SDK's own.
DEPTH_MODES = {
    "NFOV_2X2BINNED": Cut((512, 512), (96, 90), (320, 288)),
    "NFOV_UNBINNED": Cut((1024, 1024), (192, 180), (640, 576)),
    "WFOV_2X2BINNED": Cut((512, 512), (0, 0), (512, 512)),
    "WFOV_UNBINNED": Cut((1024, 1024), (0, 0), (1024, 1024)),
}
DEPTH_FPS = {
    "NFOV_UNBINNED": 30,
    "NFOV_2X2BINNED": 30,
    "WFOV_2X2BINNED": 30,
    "WFOV_UNBINNED": 15,
}
"""Frames a second that a camera is asked for in each depth mode: the most that an Azure Kinect has
(hardware specification), and a Femto has all of them."""
COLOUR_RESOLUTIONS = {
    "720P": Cut((1280, 960), (0, 120), (1280, 720)),
    "1080P": Cut((1920, 1440), (0, 180), (1920, 1080)),
    "1440P": Cut((2560, 1920), (0, 240), (2560, 1440)),
    "1536P": Cut((2048, 1536), (0, 0), (2048, 1536)),
    "2160P": Cut((3840, 2880), (0, 360), (3840, 2160)),
    "3072P": Cut((4096, 3072), (0, 0), (4096, 3072)),
}

_DEPTH, _COLOUR = "CALIBRATION_CameraLocationD0", "CALIBRATION_CameraLocationPV0"
_PARAMETERS = 14
"""cx, cy, fx, fy, k1 to k6, centre of distortion x and y (always 0), p2, p1."""
_LENS_MODEL = "CALIBRATION_LensDistortionModelBrownConrady"
"""OpenCV's rational model. The only other one, Rational6KT, was never sold."""
_MM_PER_M = 1000.0
_HUGE = 1e6
"""No lens has such a coefficient, and no camera is that large."""


def from_json(data: bytes, *, depth_mode: str, colour_resolution: str | None, fps: int) -> Camera:
    """Read a device's factory calibration for one depth mode and one colour resolution.

    `depth_mode` and `colour_resolution` are keys of the tables above; None: colour is off, and
    then `colour_from_depth` is the identity. Raises `CalibrationError`.
    """
    if depth_mode not in DEPTH_MODES:
        raise CalibrationError(
            f"unknown depth mode {depth_mode!r}; choose from: {', '.join(DEPTH_MODES)}"
        )
    if colour_resolution is not None and colour_resolution not in COLOUR_RESOLUTIONS:
        choices = ", ".join(COLOUR_RESOLUTIONS)
        raise CalibrationError(
            f"unknown colour resolution {colour_resolution!r}; choose from: {choices}"
        )
    information = _member(_parsed(data), "CalibrationInformation", dict)
    depth = _camera_at(information, _DEPTH)
    colour, colour_from_depth = None, np.eye(4)
    if colour_resolution is not None:
        entry = _camera_at(information, _COLOUR)
        colour = _lens(entry, COLOUR_RESOLUTIONS[colour_resolution])
        colour_from_depth = _pose(entry) @ np.linalg.inv(_pose(depth))
    return Camera(
        serial=_member(_member(information, "Metadata", dict), "SerialId", str),
        depth_mode=depth_mode,
        fps=fps,
        depth=_lens(depth, DEPTH_MODES[depth_mode]),
        colour=colour,
        colour_from_depth=colour_from_depth,
    )


def to_json(camera: Camera) -> bytes:
    """Write `camera` as the SDK's calibration file; `from_json` reads it back.

    Raises KeyError or ValueError for a camera in none of the Azure Kinect's modes.
    """
    cut = DEPTH_MODES[camera.depth_mode]
    cameras = [_camera_entry(camera.depth, cut, _DEPTH, "Depth", np.eye(4))]
    if camera.colour is not None:
        cut = COLOUR_RESOLUTIONS[colour_resolution_of(camera.colour)]
        pose = camera.colour_from_depth
        cameras.append(_camera_entry(camera.colour, cut, _COLOUR, "PhotoVideo", pose))
    information = {
        "Cameras": cameras,
        "InertialSensors": [],
        "Metadata": {"SerialId": camera.serial, "Version": {"Major": 1, "Minor": 2}},
    }
    return json.dumps({"CalibrationInformation": information}, indent=1).encode()


def colour_resolution_of(lens: Lens) -> str:
    """Name the colour resolution of that size; raises ValueError if the Kinect has none."""
    for name, cut in COLOUR_RESOLUTIONS.items():
        if cut.size == (lens.width, lens.height):
            return name
    raise ValueError(f"no colour resolution of {lens.width} x {lens.height}")


def _lens(entry: dict[str, Any], cut: Cut) -> Lens:
    intrinsics = _member(entry, "Intrinsics", dict)
    model = _member(intrinsics, "ModelType", str)
    if model != _LENS_MODEL:
        raise CalibrationError(f"unknown lens model {model!r} in the calibration")
    cx, cy, fx, fy, k1, k2, k3, k4, k5, k6, _, _, p2, p1 = _numbers(
        intrinsics, "ModelParameters", _PARAMETERS
    )
    if fx <= 0 or fy <= 0:
        raise CalibrationError("the calibration has a focal length that is not positive")
    (scaled_x, scaled_y), (left, top), (width, height) = cut.scaled, cut.offset, cut.size
    return Lens(
        width=width,
        height=height,
        fx=fx * scaled_x,
        fy=fy * scaled_y,
        cx=cx * scaled_x - left - 0.5,
        cy=cy * scaled_y - top - 0.5,
        distortion=(k1, k2, p1, p2, k3, k4, k5, k6),
    )


def _camera_entry(
    lens: Lens, cut: Cut, location: str, purpose: str, pose: Points
) -> dict[str, Any]:
    (scaled_x, scaled_y), (left, top) = cut.scaled, cut.offset
    k1, k2, p1, p2, k3, k4, k5, k6 = lens.distortion
    centre = [(lens.cx + left + 0.5) / scaled_x, (lens.cy + top + 0.5) / scaled_y]
    focal = [lens.fx / scaled_x, lens.fy / scaled_y]
    whole = (
        DEPTH_MODES["WFOV_UNBINNED"] if location == _DEPTH else COLOUR_RESOLUTIONS["3072P"]
    ).size
    return {
        "Intrinsics": {
            "ModelParameterCount": _PARAMETERS,
            "ModelParameters": [*centre, *focal, k1, k2, k3, k4, k5, k6, 0.0, 0.0, p2, p1],
            "ModelType": _LENS_MODEL,
        },
        "Location": location,
        "Purpose": f"CALIBRATION_CameraPurpose{purpose}",
        # 0: the lens model is not limited to a radius around the optical axis.
        "MetricRadius": 0,
        "Rt": {
            "Rotation": pose[:3, :3].ravel().tolist(),
            "Translation": (pose[:3, 3] / _MM_PER_M).tolist(),
        },
        "SensorHeight": whole[1],
        "SensorWidth": whole[0],
        "Shutter": "CALIBRATION_ShutterTypeUndefined",
        "ThermalAdjustmentParams": {"Params": [0] * 12},
    }


def _pose(entry: dict[str, Any]) -> Points:
    """(4, 4), mm: p_camera = M p_device."""
    rt = _member(entry, "Rt", dict)
    pose = np.eye(4)
    pose[:3, :3] = np.reshape(_numbers(rt, "Rotation", 9), (3, 3))
    pose[:3, 3] = np.multiply(_numbers(rt, "Translation", 3), _MM_PER_M)
    if abs(np.linalg.det(pose) - 1.0) > 1e-3:
        raise CalibrationError("the calibration's 'Rotation' is not a rotation")
    return pose


def _parsed(data: bytes) -> dict[str, Any]:
    try:
        # The SDK stores a C string: a NUL may follow the last brace.
        parsed = json.loads(data.rstrip(b"\0").decode("utf-8-sig"))
    except (ValueError, RecursionError) as error:
        raise CalibrationError(f"the calibration is not JSON ({error})") from error
    if not isinstance(parsed, dict):
        raise CalibrationError("the calibration is not a JSON object")
    return parsed


def _camera_at(information: dict[str, Any], location: str) -> dict[str, Any]:
    for entry in _member(information, "Cameras", list):
        if isinstance(entry, dict) and entry.get("Location") == location:
            return entry
    raise CalibrationError(f"the calibration has no camera at {location!r}")


def _member(parent: dict[str, Any], name: str, kind: type[_T]) -> _T:
    value = parent.get(name)
    if not isinstance(value, kind):
        raise CalibrationError(f"the calibration has no {name!r}, or not as {kind.__name__}")
    return value


def _numbers(parent: dict[str, Any], name: str, count: int) -> list[float]:
    values = _member(parent, name, list)
    if len(values) != count:
        raise CalibrationError(f"the calibration's {name!r} has {len(values)} numbers, not {count}")
    if any(not isinstance(v, int | float) or isinstance(v, bool) for v in values):
        raise CalibrationError(f"the calibration's {name!r} holds something that is not a number")
    # Also false for NaN.
    if not all(-_HUGE < v < _HUGE for v in values):
        raise CalibrationError(f"the calibration's {name!r} holds a number out of range")
    return [float(v) for v in values]
