"""A Femto's factory calibration, as the SDK returns it for two stream profiles, to our `Camera`.

Rule: pure; it reads the SDK's values and calls nothing that changes the device. The SDK's lengths
are mm, its pixels have (0, 0) at the centre, its model is OpenCV's rational one
(`OB_DISTORTION_BROWN_CONRADY_K6`), and it names no depth mode: the image's size does.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from halo_service.errors import UserError
from halo_service.geometry import k4a
from halo_service.geometry.camera import Camera, Lens
from halo_service.geometry.matrix import Matrix4

_RADIAL_6 = "BROWN_CONRADY_K6"
_RADIAL_3 = "BROWN_CONRADY"
_PLAIN = "NONE"


def mode_of(width: int, height: int) -> str:
    """Name the depth mode by the size of its image. Raises `UserError` for another size."""
    for name, cut in k4a.DEPTH_MODES.items():
        if cut.size == (width, height):
            return name
    raise UserError(
        f"depth of {width} x {height} is in no mode of a Femto; "
        f"choose from: {', '.join(k4a.DEPTH_MODES)}"
    )


def camera_of(serial: str, depth: Any, colour: Any | None) -> Camera:
    """Make our `Camera`.

    `depth`, `colour`: the SDK's video stream profiles; None: no colour. Depth without a rate has
    its mode's. Raises `UserError` if the calibration cannot be used.
    """
    lens = _lens(depth, "depth")
    mode = mode_of(lens.width, lens.height)
    return Camera(
        serial=serial,
        depth_mode=mode,
        fps=int(depth.get_fps()) or k4a.DEPTH_FPS[mode],
        depth=lens,
        colour=None if colour is None else _lens(colour, "colour"),
        colour_from_depth=np.eye(4) if colour is None else _pose(depth.get_extrinsic_to(colour)),
    )


def _lens(profile: Any, what: str) -> Lens:
    lens, distortion = profile.get_intrinsic(), profile.get_distortion()
    numbers = [getattr(lens, name) for name in ("fx", "fy", "cx", "cy")]
    model = distortion.model.name
    if model not in (_RADIAL_6, _RADIAL_3, _PLAIN):
        raise UserError(f"the {what} camera has the unknown lens model {model}; update the SDK")
    fx, fy, cx, cy = map(float, numbers)
    k1, k2, k3, p1, p2 = (
        float(getattr(distortion, name)) for name in ("k1", "k2", "k3", "p1", "p2")
    )
    k4, k5, k6 = (
        (float(distortion.k4), float(distortion.k5), float(distortion.k6))
        if model == _RADIAL_6
        else (0.0, 0.0, 0.0)
    )
    bends = (k1, k2, p1, p2, k3, k4, k5, k6) if model != _PLAIN else (0.0,) * 8
    width, height = profile.get_width(), profile.get_height()
    if not np.isfinite((fx, fy, cx, cy, *bends)).all() or min(fx, fy) <= 0:
        raise UserError(
            f"the camera reports no calibration of its {what} lens: update its firmware, or send "
            "it to its maker"
        )
    if (lens.width, lens.height) != (width, height):
        raise UserError(
            f"the calibration of the {what} lens is for {lens.width} x {lens.height}, and its "
            f"image has {width} x {height}: update the SDK"
        )
    return Lens(width, height, fx, fy, cx, cy, bends)


def _pose(extrinsic: Any) -> Matrix4:
    """(4, 4), mm: p_colour = M p_depth."""
    pose = np.eye(4)
    pose[:3, :3] = np.asarray(extrinsic.rot, dtype=np.float64).reshape(3, 3)
    pose[:3, 3] = np.asarray(extrinsic.transform, dtype=np.float64)
    if not np.isfinite(pose).all() or abs(np.linalg.det(pose) - 1.0) > 1e-3:
        raise UserError("the camera reports no pose of its colour camera: update its firmware")
    return pose
