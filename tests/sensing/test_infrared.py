"""In touch, skin reads like the surface: infrared and the hand's bones show where a finger is."""

from __future__ import annotations

from dataclasses import replace

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from halo_service.profile import Background
from halo_service.sensing import SensingSettings, start, step
from halo_service.sensing.finger_frame import FingerFrame
from halo_service.sensing.outline import outline
from halo_service.sensing.segmentation import infrared_silhouette, segment
from halo_service.values import Touch
from tests.drawn import FRAME_US, PLAIN

SHAPE = (576, 640)
TIP = (320, 300)
RADIUS = 8
NOISE = 0.04
EMPTY = Background(
    np.full(SHAPE, 500.0, np.float32),
    np.ones(SHAPE, np.float32),
    np.ones(SHAPE, np.bool_),
    np.full(SHAPE, 5000.0, np.float32),
    NOISE,
)


FLAT = np.zeros(SHAPE, np.float32)
FLAT[TIP[1] + 20 : 500, TIP[0] - RADIUS : TIP[0] + RADIUS] = -40.0
"""Excess depth of a finger: its last 2 cm read like the surface."""


def infrared(side: float, middle: float) -> NDArray[np.uint16]:
    """Draw a finger that points up the image, in shares of the surface's brightness."""
    share = np.ones(SHAPE, np.float32)
    for radius, value in ((RADIUS, side), (RADIUS // 2 - 1, middle)):
        end = (TIP[0], TIP[1] + RADIUS)
        cv2.line(share, end, (TIP[0], 500), value, thickness=2 * radius)
        cv2.circle(share, end, radius, value, thickness=-1)
    noise = np.random.default_rng(1).normal(1.0, NOISE, SHAPE)
    return np.clip(5000.0 * share * noise, 0, 65535).astype(np.uint16)


@pytest.mark.parametrize("middle", [0.5, 1.0, 1.4], ids=["dark", "as the table", "bright"])
def test_a_finger_differs_in_infrared_though_its_middle_is_as_bright_as_the_table(
    middle: float,
) -> None:
    solid = infrared_silhouette(infrared(0.5, middle), EMPTY, FLAT, 1.0)
    assert solid is not None
    assert solid[TIP[1] + 6 : 480, TIP[0] - 5 : TIP[0] + 5].all()
    assert not solid[: TIP[1] - 3].any()
    assert not solid[:, : TIP[0] - RADIUS - 3].any()


def test_an_older_profile_knows_no_infrared() -> None:
    old = Background(EMPTY.mean_mm, EMPTY.noise_mm, EMPTY.valid)
    assert infrared_silhouette(infrared(0.5, 0.5), old, FLAT, 1.0) is None


@pytest.mark.parametrize("brightness", [0.5, 1.6], ids=["dark", "bright"])
def test_a_sheet_that_was_laid_on_the_table_since_is_no_finger(brightness: float) -> None:
    on_sheet = (infrared(0.5, 0.5) * brightness).astype(np.uint16)
    solid = infrared_silhouette(on_sheet, EMPTY, FLAT, 1.0)
    assert solid is not None
    on_table = infrared_silhouette(infrared(0.5, 0.5), EMPTY, FLAT, 1.0)
    assert np.count_nonzero(solid != on_table) < 10  # rounded, near the threshold


def test_a_finger_that_reads_below_the_surface_ends_where_infrared_ends() -> None:
    """Pressed, its last centimetre reads 6 mm too far, and the dent around it hardly farther."""
    excess = np.zeros(SHAPE, np.float32)
    cv2.circle(excess, (TIP[0], TIP[1] + 6), 20, 9.0, thickness=-1)
    finger = infrared(0.5, 0.5) < 3750
    rows = np.arange(SHAPE[0], dtype=np.float32)[:, None] - np.float32(TIP[1])
    reads = 6.0 - np.maximum(rows - 10.0, 0.0)
    excess = np.where(finger, np.broadcast_to(reads, SHAPE), excess).astype(np.float32)
    depth = (500.0 + excess).astype(np.uint16)
    guess = FingerFrame((TIP[0], TIP[1] + 6.0), (0.0, -1.0), 1.0)

    def off_mm(solid: NDArray[np.bool_] | None) -> float:
        found = outline(segment(excess, SensingSettings(), 8.0, solid), depth, guess, RADIUS)
        return float("inf") if found is None else abs(found.place.tip_px[1] - TIP[1])

    assert off_mm(None) > 4.0
    assert off_mm(infrared_silhouette(infrared(0.5, 0.5), EMPTY, excess, 1.0)) < 1.5


def test_a_flat_finger_that_reads_like_the_surface_is_followed_into_its_touch() -> None:
    """Its skin reads 12 mm too far, all along the finger."""
    brightness = np.full(PLAIN.shape, 5000.0, np.float32)
    background = replace(PLAIN.profile.background, infrared=brightness, infrared_noise=NOISE)
    state = start(replace(PLAIN.profile, background=background), SensingSettings())
    seen = []
    for n, (dent_mm, height_mm) in enumerate(((9.0, 10.0), (9.0, 10.0), (12.0, 0.0), (12.0, 0.0))):
        drawn = PLAIN.frame(dent_mm=dent_mm, height_mm=height_mm, time_us=n * FRAME_US)
        finger = drawn.depth < PLAIN.distance_mm
        dark = np.where(finger, 2500, 5000).astype(np.uint16)
        shown = replace(drawn, depth=drawn.depth + np.uint16(12) * finger, ir=dark)
        result, state = step(state, shown, PLAIN.hands(time_us=n * FRAME_US))
        seen.append([(pointer.id, pointer.state) for pointer in result.pointers])
    assert seen == [[(1, Touch.HOVER)]] * 2 + [[(1, Touch.TOUCH)]] * 2
