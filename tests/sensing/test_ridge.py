"""A finger's angles are read off its ridge."""

from __future__ import annotations

import math

import numpy as np
import pytest

from halo_service.geometry.camera import Camera
from halo_service.profile import Profile
from halo_service.sensing.finger_frame import FingerFrame
from halo_service.sensing.ridge import TAPER_DEG, angles
from halo_service.sensing.segmentation import segment
from halo_service.sensing.settings import SensingSettings

DISTANCE_MM, RADIUS_PX = 500.0, 7


def finger(pitch_deg: float, yaw_deg: float, *, wedge: bool = False) -> np.ndarray:
    """Draw a round finger whose upper side rises at a pitch; its tip is in the image's middle."""
    depth = np.full((576, 640), DISTANCE_MM)
    rows, columns = np.mgrid[:576, :640]
    yaw = math.radians(yaw_deg)
    back = (rows - 288) * math.cos(yaw) - (columns - 320) * math.sin(yaw)
    side = (columns - 320) * math.cos(yaw) + (rows - 288) * math.sin(yaw)
    round_mm = np.sqrt(np.maximum(RADIUS_PX**2 - side**2, 0.0)) - RADIUS_PX
    top = 12.0 + back * math.tan(math.radians(pitch_deg)) + round_mm
    inside = (back >= 0) & (back < 60) & (np.abs(side) <= RADIUS_PX)
    if wedge:
        block = (back >= 4) & (back < 40) & (side > -12) & (side < 3)
        depth[block] -= np.maximum((back[block] - 4.0) * math.tan(math.radians(pitch_deg)), 4.5)
    depth[inside] = DISTANCE_MM - top[inside]
    return np.rint(depth).astype(np.uint16)


@pytest.mark.parametrize("wedge", [False, True], ids=["bare", "on a wedge"])
@pytest.mark.parametrize("yaw_deg", [-35.0, 0.0, 20.0])
@pytest.mark.parametrize("pitch_deg", [20.0, 45.0, 55.0])
def test_pitch_and_yaw_are_those_of_the_upper_side(
    camera: Camera, profile: Profile, pitch_deg: float, yaw_deg: float, wedge: bool
) -> None:
    depth = finger(pitch_deg, yaw_deg, wedge=wedge)
    yaw = math.radians(yaw_deg + 6.0)  # the landmarks' direction is some degrees off
    direction = (math.sin(yaw), -math.cos(yaw))
    excess = (depth - DISTANCE_MM).astype(np.float32)
    segmentation = segment(excess, SensingSettings(), 8.0)
    place = FingerFrame((320.0, 288.0), direction, 1.0)
    found = angles(depth, segmentation, place, camera, profile.surface)
    assert found is not None
    assert found.pitch_deg + TAPER_DEG == pytest.approx(pitch_deg, abs=4.0)
    assert found.yaw_deg == pytest.approx(yaw_deg, abs=3.5)


def test_where_no_finger_is_there_are_no_angles(camera: Camera, profile: Profile) -> None:
    empty = np.full((576, 640), 500, np.uint16)
    nothing = segment(np.zeros(empty.shape, np.float32), SensingSettings(), 8.0)
    for tip in ((320.0, 288.0), (-50.0, 700.0)):
        place = FingerFrame(tip, (0.0, -1.0), 1.0)
        assert angles(empty, nothing, place, camera, profile.surface) is None
