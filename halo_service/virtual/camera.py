"""The virtual devices and their factory calibrations.

Typical of each device class: the magnitudes are those that public calibrations show, the numbers
are chosen. One device of a class: the same over all seeds, as a user has one camera.
"""

from __future__ import annotations

import functools
from dataclasses import dataclass

import numpy as np

from halo_service.geometry import k4a
from halo_service.geometry.camera import Camera, Lens, Points

SERIAL = "VIRTUAL-0001"
"""Of the device; `Room.camera` appends the room."""
DEPTH_MODE = "NFOV_UNBINNED"
NARROW_FX = 504.2
"""Focal length of the narrow unbinned mode, px: lengths in pixels are measured there."""


@dataclass(frozen=True, slots=True)
class Mode:
    """What changes with the depth mode besides the lens's cut."""

    field: float
    """Radius of the illuminated circle in half image heights. Narrow: the corners read nothing (a
    public recording: about 340 px). Wide: the round field of 120 degrees fills the image (hardware
    specification)."""
    signal: float
    """Infrared of the narrow unbinned mode's: the square of the published operating ranges (3.86,
    5.46, 2.88 and 2.21 m)."""
    exposure: float = 1.0
    """Its exposure's length, of the narrow unbinned mode's (12.8 and 20.3 ms: hardware
    specification)."""
    idle_us: float = 1450.0
    """Between two of the nine pulses of its laser (hardware specification, depth sensor raw
    timing)."""


MODES = {
    "NFOV_UNBINNED": Mode(1.18, 1.0),
    "NFOV_2X2BINNED": Mode(1.18, 2.0),
    "WFOV_2X2BINNED": Mode(1.0, 0.56),
    "WFOV_UNBINNED": Mode(1.0, 0.33, exposure=1.59, idle_us=2390.0),
}
"""Both devices have them: it is the same sensor. Their rates are `k4a.DEPTH_FPS`."""


@dataclass(frozen=True, slots=True)
class Device:
    """One class of device."""

    serial: str
    depth: Lens
    """In the narrow unbinned mode."""
    colour: Lens
    """At 720p."""
    tilt_deg: float
    """Between the axes of the two lenses."""
    colour_mm: tuple[float, float, float]
    """Translation of `colour_from_depth`."""
    fps: tuple[float, float] = (30.0, 30.0)
    """Range of the frame rate by host time in the narrow unbinned mode; a seed draws one."""


DEVICES = {
    # Rational lens model: numerator and denominator nearly cancel, what is left is a barrel.
    "kinect": Device(
        SERIAL,
        depth=Lens(
            width=640,
            height=576,
            fx=NARROW_FX,
            fy=504.4,
            cx=322.6,
            cy=330.1,
            distortion=(0.52, -0.018, 2.4e-5, -6.8e-5, -0.0024, 0.862, 0.084, -0.0131),
        ),
        colour=Lens(
            width=1280,
            height=720,
            fx=611.3,
            fy=611.1,
            cx=638.4,
            cy=366.2,
            distortion=(0.31, -2.41, -1.5e-4, -1.2e-4, 1.42, 0.19, -2.23, 1.345),
        ),
        tilt_deg=5.0,  # public calibrations show 4.9 to 5.2
        colour_mm=(-32.0, -2.1, 3.9),  # data sheet's drawing
    ),
    # Magnitudes of the Bolts in OrbbecSDK #56 and #151; rates: OrbbecSDK #49.
    "bolt": Device(
        "VIRTUAL-BOLT-0001",
        depth=Lens(
            width=640,
            height=576,
            fx=504.9,
            fy=504.8,
            cx=331.4,
            cy=336.2,
            distortion=(12.4, 6.41, 5.1e-5, -1.9e-5, 0.246, 12.72, 10.62, 1.507),
        ),
        colour=Lens(
            width=1280,
            height=720,
            fx=747.6,
            fy=747.2,
            cx=635.1,
            cy=371.8,
            distortion=(0.0772, -0.109, -4.2e-4, 2.9e-4, 0.0454, 0.0, 0.0, 0.0),
        ),
        tilt_deg=6.3,
        colour_mm=(-32.3, -1.2, 1.8),
        fps=(30.03, 30.14),
    ),
}


@functools.cache
def factory(device: str = "kinect", mode: str = DEPTH_MODE) -> Camera:
    """The calibration of a virtual device in one of its depth modes."""
    made = DEVICES[device]
    colour_from_depth = _colour_from_depth(made)
    fps = k4a.DEPTH_FPS[mode]
    camera = Camera(made.serial, DEPTH_MODE, fps, made.depth, made.colour, colour_from_depth)
    if mode == DEPTH_MODE:
        return camera
    # The cut of the sensor that the SDK shows in that mode.
    return k4a.from_json(k4a.to_json(camera), depth_mode=mode, colour_resolution="720P", fps=fps)


def px_times(lens: Lens) -> float:
    """Pixels of a lens for one of the narrow unbinned mode."""
    return lens.fx / NARROW_FX


def _colour_from_depth(device: Device) -> Points:
    tilt = np.radians(device.tilt_deg)
    transform = np.eye(4)
    transform[1:3, 1:3] = [[np.cos(tilt), np.sin(tilt)], [-np.sin(tilt), np.cos(tilt)]]
    transform[:3, 3] = device.colour_mm
    return transform


@functools.lru_cache(maxsize=8)
def pixel_rays(lens: Lens) -> Points:
    """(H, W, 3) the direction of each pixel's centre, z = 1."""
    # Row by row: arrays for all pixels do not stay in the processor's cache.
    columns = np.arange(float(lens.width))
    rows = (np.full(lens.width, float(row)) for row in range(lens.height))
    return np.stack([lens.rays(np.column_stack([columns, row])) for row in rows])


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
