"""The virtual device's factory calibration.

Typical of the device class: the magnitudes are those that public calibrations of Azure Kinects
show, the numbers are chosen. One device: the same over all seeds, as a user has one camera.
"""

from __future__ import annotations

import functools

import numpy as np

from halo_service.geometry.camera import Camera, Lens, Points

SERIAL = "VIRTUAL-0001"
DEPTH_MODE = "NFOV_UNBINNED"
FPS = 30

# Rational lens model: the numerator and denominator nearly cancel, what is left is a barrel of
# about 1.5 % at the image's edge.
_DEPTH = Lens(
    width=640,
    height=576,
    fx=504.2,
    fy=504.4,
    cx=322.6,
    cy=330.1,
    distortion=(0.52, -0.018, 2.4e-5, -6.8e-5, -0.0024, 0.862, 0.084, -0.0131),
)
_COLOUR = Lens(
    width=1280,
    height=720,
    fx=611.3,
    fy=611.1,
    cx=638.4,
    cy=366.2,
    distortion=(0.31, -2.41, -1.5e-4, -1.2e-4, 1.42, 0.19, -2.23, 1.345),
)
BASELINE_MM = 32.0
"""Colour lens to depth lens, data sheet's drawing."""
COLOUR_TILT_DEG = 5.0
"""About what separates the two lenses' axes; public calibrations show 4.9 to 5.2."""


@functools.cache
def factory() -> Camera:
    """The virtual Kinect's calibration."""
    return Camera(SERIAL, DEPTH_MODE, FPS, _DEPTH, _COLOUR, _colour_from_depth())


def _colour_from_depth() -> Points:
    tilt = np.radians(COLOUR_TILT_DEG)
    transform = np.eye(4)
    transform[1:3, 1:3] = [[np.cos(tilt), np.sin(tilt)], [-np.sin(tilt), np.cos(tilt)]]
    transform[:3, 3] = (-BASELINE_MM, -2.1, 3.9)
    return transform


@functools.lru_cache(maxsize=8)
def pixel_rays(lens: Lens) -> Points:
    """(H, W, 3) the direction of each pixel's centre, z = 1."""
    rows, columns = np.mgrid[: lens.height, : lens.width]
    px = np.column_stack([columns.ravel(), rows.ravel()]).astype(np.float64)
    return lens.rays(px).reshape(lens.height, lens.width, 3)


def shrunk(lens: Lens, times: int) -> Lens:
    """The same view in an image `times` smaller; pixel centres stay at whole numbers."""
    return Lens(
        lens.width // times,
        lens.height // times,
        lens.fx / times,
        lens.fy / times,
        (lens.cx + 0.5) / times - 0.5,
        (lens.cy + 0.5) / times - 0.5,
        lens.distortion,
    )
