"""The template finds a finger where the landmarks are off and where a neighbour touches it."""

from __future__ import annotations

import math

import numpy as np
import pytest

from halo_service.sensing.finger_fit import fit_finger
from halo_service.sensing.finger_frame import FingerFrame, unit

RADIUS_MM = 7.0
END = (60.0, 50.0)
Point = tuple[float, float]


def away(end: Point, yaw_deg: float, px_per_mm: float) -> np.ndarray:
    """Return how far each pixel is from a finger with this end, mm; negative inside."""
    rows, columns = np.mgrid[:160, :160].astype(np.float32)
    yaw = math.radians(yaw_deg)
    x, y = (columns - end[0]) / px_per_mm, (rows - end[1]) / px_per_mm
    ahead, across = x * math.sin(yaw) - y * math.cos(yaw), x * math.cos(yaw) + y * math.sin(yaw)
    return np.hypot(np.maximum(ahead + RADIUS_MM, 0.0), across) - RADIUS_MM


def guess(off_mm: Point, px_per_mm: float, yaw_deg: float = 0.0) -> FingerFrame:
    yaw = math.radians(yaw_deg)
    x, y = (end + off * px_per_mm for end, off in zip(END, off_mm, strict=True))
    return FingerFrame((x, y), (math.sin(yaw), -math.cos(yaw)), px_per_mm)


@pytest.mark.parametrize("px_per_mm", [0.5, 1.0, 1.7])
@pytest.mark.parametrize("yaw_deg", [-20.0, 0.0, 30.0])
@pytest.mark.parametrize("off_mm", [(0.0, 0.0), (4.0, 8.0), (-5.0, -10.0), (0.0, 18.0)])
def test_a_lone_finger_is_found(px_per_mm: float, yaw_deg: float, off_mm: Point) -> None:
    mask = np.where(away(END, yaw_deg, px_per_mm) < 0.0, 1.0, -1.0).astype(np.float32)
    found = fit_finger(mask, guess(off_mm, px_per_mm), RADIUS_MM)
    assert found is not None
    assert math.dist(found.place.tip_px, END) < 4.0 * px_per_mm  # two samples
    turned = math.degrees(math.atan2(found.place.direction[0], -found.place.direction[1]))
    assert turned == pytest.approx(yaw_deg, abs=17.0)


@pytest.mark.parametrize("off_mm", [(3.0, 2.0), (4.0, -2.0), (0.0, 4.0)])
@pytest.mark.parametrize("longer_mm", [0.0, 12.0])
def test_a_neighbour_that_touches_its_side_is_not_taken_for_it(
    off_mm: Point, longer_mm: float
) -> None:
    """The bones are off by as much as the landmarks: a strip of the neighbour counts as its own."""
    neighbour = (END[0] + 2.0 * RADIUS_MM, END[1] - longer_mm)
    finger = np.minimum(away(END, 0.0, 1.0), away(neighbour, 0.0, 1.0)) < 0.0
    columns = np.arange(160, dtype=np.float32)[None, :]
    border = END[0] + RADIUS_MM + off_mm[0]
    share = 1.0 / (1.0 + np.exp(np.clip(columns - border, -30.0, 30.0)))
    mask = np.where(finger, 2.0 * share - 1.0, -1.0).astype(np.float32)
    found = fit_finger(mask, guess(off_mm, 1.0), RADIUS_MM)
    assert found is not None
    assert math.dist(found.place.tip_px, END) < 4.5


def test_between_two_equal_fingers_the_landmarks_decide() -> None:
    other = (END[0] + 20.0, END[1])
    finger = np.minimum(away(END, 0.0, 1.0), away(other, 0.0, 1.0)) < 0.0
    mask = np.where(finger, 1.0, -1.0).astype(np.float32)
    for off_mm, end in (((4.0, 3.0), END), ((16.0, 3.0), other)):
        found = fit_finger(mask, guess(off_mm, 1.0), RADIUS_MM)
        assert found is not None
        assert math.dist(found.place.tip_px, end) < 3.0


def test_no_finger_is_no_fit() -> None:
    surface, hand = np.full((160, 160), -1.0, np.float32), np.ones((160, 160), np.float32)
    assert fit_finger(surface, guess((0.0, 0.0), 1.0), RADIUS_MM) is None
    assert fit_finger(hand, guess((0.0, 0.0), 1.0), RADIUS_MM) is None
    outside = FingerFrame((-500.0, 50.0), unit((0.0, 1.0), (0.0, 0.0)), 1.0)
    assert fit_finger(hand, outside, RADIUS_MM) is None
