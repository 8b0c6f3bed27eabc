"""A drawn table: a flat surface at 500 mm, a finger above it, a dent around its tip.

For unit tests of the sensing only: it looks like nothing real, but each number in it is known.
"""

from __future__ import annotations

from collections.abc import Callable

import cv2
import numpy as np
import pytest

from halo_service.geometry.camera import Camera, Lens
from halo_service.geometry.surface import Surface
from halo_service.profile import Background, HeldState, Profile, TouchStates
from halo_service.sensing.extraction import FREE_PX
from halo_service.values import Frame, Hand, Side, Tracked

DISTANCE_MM = 500.0
FRAME_US = 33_333
DENT_PX, SHOWN_PX = 30 * 8, 493
"""The drawn dent lies eight rows beyond the tip, within the patch, where no finger is; of the
patch's 600 pixels the drawn finger leaves so many free."""
PER_DENT_MM = DENT_PX * FREE_PX / SHOWN_PX
"""Signal of a dent, mm px a mm."""


@pytest.fixture(scope="session")
def camera() -> Camera:
    """A plain pinhole: 1 px is 1 mm at 500 mm."""
    lens = Lens(640, 576, 500.0, 500.0, 319.5, 287.5)
    return Camera("DRAWN", "NFOV_UNBINNED", 30, lens, None, np.eye(4))


@pytest.fixture(scope="session")
def profile(camera: Camera) -> Profile:
    """300 x 200 mm around the optical axis; the four states at 500, 1500, 2000 and 3000 mm px."""
    camera_from_surface = np.eye(4)
    camera_from_surface[:3, 3] = (-150.0, -100.0, DISTANCE_MM)
    shape = (camera.depth.height, camera.depth.width)
    background = Background(
        np.full(shape, DISTANCE_MM, np.float32), np.ones(shape, np.float32), np.ones(shape, bool)
    )
    states = TouchStates(
        hover=HeldState(500.0, 10.0, 0.0),
        subtle=HeldState(1500.0, 1.0, 0.0),
        touch=HeldState(2000.0, 0.0, 25.0),
        pressure=HeldState(3000.0, 0.0, 200.0),
        line_px_at_hover=6.0,
        finger_thickness_mm=14.0,
    )
    surface = Surface("table", 300.0, 200.0, camera_from_surface)
    return Profile("drawn", camera, surface, background, states, 1)


@pytest.fixture(scope="session")
def draw() -> Callable[..., Frame]:
    """Draw a finger that points up the image, its silhouette ending at `tip` px.

    `signal`: the halo's strength in the patch, mm px; `height_mm`: of the pad.
    """

    def drawn(
        tip: tuple[float, float] = (320.0, 288.0),
        signal: float = 0.0,
        height_mm: float = 0.0,
        time_us: int = 0,
    ) -> Frame:
        depth = np.full((576, 640), DISTANCE_MM, np.uint16)
        if signal > 0.0:
            x, y = round(tip[0]), round(tip[1])
            depth[max(y - 8, 0) : max(y, 0), max(x - 15, 0) : max(x + 15, 0)] = round(
                DISTANCE_MM + signal / PER_DENT_MM
            )
        top = round(DISTANCE_MM - 14.0 - height_mm)
        start = (round(tip[0]), round(tip[1]) + 8)
        cv2.line(depth, start, (start[0], start[1] + 80), top, thickness=16)
        cv2.circle(depth, start, 8, top, thickness=-1)
        return Frame(time_us, depth, np.full((576, 640), 1000, np.uint16))

    return drawn


@pytest.fixture(scope="session")
def see() -> Callable[..., Tracked]:
    """A tracker that sees the index finger of a right hand, as far off as it is told."""

    def seen(
        tip: tuple[float, float] = (320.0, 288.0),
        time_us: int = 0,
        off: tuple[float, float] = (0.0, 0.0),
    ) -> Tracked:
        landmarks = np.full((21, 2), (tip[0], tip[1] + 150.0))
        landmarks[5:9] = [(tip[0], tip[1] + below) for below in (90.0, 60.0, 30.0, 6.0)]
        return Tracked(time_us, (Hand(Side.RIGHT, landmarks + np.array(off), 0.9),))

    return seen
