"""A long nail moves the outline's end, not the halo: the reported place follows the halo."""

from __future__ import annotations

import math

import numpy as np
import pytest

from halo_service.profile import Profile
from halo_service.sensing.nail import halo_behind_mm, pad_under_nail
from tests.sensing.test_readings import COLUMNS, FINGER_PX, PAD_PX, ROWS, bell, found, segmentation


def touching(halo_at_mm: float) -> np.ndarray:
    """A finger that points up the image, over a halo so far behind the pad: a pixel is a mm."""
    right, down = COLUMNS - PAD_PX[0], ROWS - PAD_PX[1]
    seen = 20.0 * bell(right, down - halo_at_mm)
    seen[(np.abs(right) < FINGER_PX) & (down > -FINGER_PX)] = -14.0
    return seen.astype(np.float32)


@pytest.mark.parametrize("behind_mm", [-4.0, 0.0, 5.0, 9.0])
def test_the_halo_shows_where_the_pad_is(profile: Profile, behind_mm: float) -> None:
    read_mm = halo_behind_mm(segmentation(touching(behind_mm)), found(), profile)
    assert read_mm == pytest.approx(behind_mm, abs=0.8)


def test_without_visible_surface_nothing_is_read(profile: Profile) -> None:
    hidden = segmentation(np.full((576, 640), -40.0, np.float32))
    assert math.isnan(halo_behind_mm(hidden, found(), profile))
    assert math.isnan(halo_behind_mm(hidden, found(at=(-90.0, 288.0)), profile))


@pytest.mark.parametrize(
    ("yaw_deg", "pitch_deg", "moved_mm"),
    [(0.0, 0.0, (0.0, 10.0)), (90.0, 60.0, (-5.0, 0.0)), (180.0, 60.0, (0.0, -5.0))],
)
def test_the_pad_lies_back_along_the_finger(
    yaw_deg: float, pitch_deg: float, moved_mm: tuple[float, float]
) -> None:
    moved = pad_under_nail((0.0, 0.0), pitch_deg, yaw_deg, 10.0)
    assert moved == pytest.approx(moved_mm, abs=1e-9)
