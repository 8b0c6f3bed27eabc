"""Each stage by itself."""

from __future__ import annotations

import numpy as np
import pytest

from halo_service.profile import Background, Profile
from halo_service.sensing.background import Drift, excess_depth, follow_drift
from halo_service.sensing.debounce import Debounce, debounce
from halo_service.sensing.detector import Detector, detect
from halo_service.sensing.extraction import extract
from halo_service.sensing.hover import hover_height
from halo_service.sensing.outline import silhouette_end
from halo_service.sensing.pressure import force, touch_pressure
from halo_service.sensing.revealer import reveal
from halo_service.sensing.settings import SensingSettings
from halo_service.sensing.states import interpolate, touch_level
from halo_service.values import Finger, Fingertip, Side, Signal

SETTINGS = SensingSettings()
FRAME_US = 33_333


def tip_at(x: float, y: float, top_mm: float = 14.0) -> Fingertip:
    return Fingertip(
        Side.RIGHT, Finger.INDEX, (x, y), (x, y + 25), (0, 0), (0, 0, 500), top_mm, 45, 0, 1
    )


@pytest.mark.parametrize(
    ("depth_mm", "valid", "expected"),
    [(512, True, 12.0), (490, True, -10.0), (0, True, 0.0), (512, False, 0.0), (500, True, 0.0)],
)
def test_excess_is_depth_less_background_and_nothing_where_nothing_was_measured(
    depth_mm: int, valid: bool, expected: float
) -> None:
    background = Background(
        np.full((2, 2), 500.0, np.float32), np.ones((2, 2), np.float32), np.full((2, 2), valid)
    )
    excess = excess_depth(np.full((2, 2), depth_mm, np.uint16), background)
    assert excess.dtype == np.float32
    assert np.all(excess == expected)


@pytest.mark.parametrize(
    ("excess_mm", "halo", "hand"),
    [(8.5, True, False), (8.0, False, False), (0.0, False, False), (-4.5, False, True)],
)
def test_the_revealer_tells_halo_from_hand(excess_mm: float, halo: bool, hand: bool) -> None:
    revealed = reveal(np.full((1, 1), excess_mm, np.float32), SETTINGS, 8.0)
    assert (bool(revealed.halo[0, 0]), bool(revealed.hand[0, 0])) == (halo, hand)


@pytest.mark.parametrize(
    ("x", "y", "pixels"),
    [(320, 288, 600), (0, 0, 150), (639, 575, 11 * 16), (-100, 50, 0), (320, 900, 0)],
    ids=["inside", "top left corner", "bottom right corner", "left of it", "below it"],
)
def test_the_patch_is_cut_at_the_images_edge(x: float, y: float, pixels: int) -> None:
    revealed = reveal(np.full((576, 640), 10.0, np.float32), SETTINGS, 8.0)
    assert extract(revealed, tip_at(x, y)) == pytest.approx(10.0 * pixels)


def test_pixels_under_the_threshold_are_not_summed() -> None:
    excess = np.full((576, 640), 7.9, np.float32)
    excess[288, 320] = 12.0
    assert extract(reveal(excess, SETTINGS, 8.0), tip_at(320, 288)) == pytest.approx(12.0)


def test_interpolation_is_the_papers_equation() -> None:
    assert interpolate(15.0, 10.0, 20.0, 1.0, 3.0) == 2.0
    assert interpolate(25.0, 10.0, 20.0, 1.0, 3.0) == 4.0


def test_the_level_is_0_at_subtle_and_1_at_touch(profile: Profile) -> None:
    assert profile.touch is not None
    assert touch_level(1500.0, profile.touch) == 0.0
    assert touch_level(2000.0, profile.touch) == 1.0


def levels(*values: float, speed_mm_s: float = 0.0) -> list[Detector]:
    """Feed levels to a detector, one a frame."""
    detector, all_of_them = None, []
    for n, level in enumerate(values):
        detector = detect(detector, level, n * FRAME_US, speed_mm_s, SETTINGS)
        all_of_them.append(detector)
    return all_of_them


@pytest.mark.parametrize(
    ("values", "touching"),
    [
        ((-1.0, -1.0, 1.0, 1.0), [False, False, True, True]),
        ((-1.0, -0.5, 0.0, 0.15), [False, False, False, False]),
        ((0.0, 0.0, 1.0, 0.15, 0.05), [False, False, True, True, False]),
        ((1.0, 1.0, 1.0, -1.0, -1.0, 1.0), [*[False] * 5, True]),
        ((*[0.3] * 60, 0.45, 0.3), [False] * 62),
        ((*[0.3] * 60, 0.6), [*[False] * 60, True]),
        (tuple(0.044 * n - 1.0 for n in range(45)), [*[False] * 41, *[True] * 4]),
    ],
    ids=[
        "a tap",
        "an approach",
        "hysteresis",
        "found while it rests",
        "a flicker above the baseline",
        "a touch above the baseline",
        "a soft landing",
    ],
)
def test_the_detector(values: tuple[float, ...], touching: list[bool]) -> None:
    assert [detector.touching for detector in levels(*values)] == touching


def test_a_finger_in_fast_flight_does_not_touch() -> None:
    assert not levels(-1.0, -1.0, 1.0, speed_mm_s=2000.0)[-1].touching


def test_long_hovering_close_by_does_not_hide_the_next_touch() -> None:
    assert levels(*[0.5] * 200, 1.0)[-1].touching


def test_the_moment_of_contact_lies_between_the_frames() -> None:
    down = levels(-1.0, 0.1, 1.0)[-1]
    assert down.ago_us == pytest.approx(FRAME_US * (1.0 - SETTINGS.down_level) / 0.9, abs=1)


@pytest.mark.parametrize(
    ("touches", "counts", "told"),
    [
        ([1, 1, 0, 0], [1, 1, 1, 1], [1, 1, 1, 0]),
        ([1, 0, 1, 0, 0], [1, 1, 1, 1, 1], [1, 1, 1, 1, 0]),
        ([1, 0, 0, 1], [1, 1, 1, 2], [1, 1, 0, 1]),
        ([0, 0, 0], [0, 0, 0], [0, 0, 0]),
    ],
)
def test_debounce_believes_an_up_when_a_second_frame_agrees(
    touches: list[int], counts: list[int], told: list[int]
) -> None:
    state, seen = Debounce(), []
    for n, touching in enumerate(touches):
        state = debounce(state, bool(touching), 0, n * FRAME_US)
        seen.append(state.contact)
    assert [contact.count for contact in seen] == counts
    assert [int(contact.touching) for contact in seen] == told


def test_an_up_that_was_doubted_tells_when_it_really_was() -> None:
    state = Debounce()
    for n, touching in enumerate([True, False, False]):
        state = debounce(state, touching, 10_000 if n == 1 else 0, n * FRAME_US)
    assert state.contact.ago_us == FRAME_US + 10_000


@pytest.mark.parametrize(
    ("signal", "line_px", "top_mm", "height_mm"),
    [
        (500.0, 6, 24.0, 10.0),
        (1500.0, 9, 15.0, 1.0),
        (1000.0, 8, 19.0, 5.5),
        (9999.0, 9, 14.0, 0.0),
        (200.0, 3, 26.0, 12.5),
        (0.0, 0, 44.0, 30.0),
        (0.0, 0, float("nan"), 15.0),
    ],
    ids=["hover", "subtle", "between", "never negative", "line", "own depth", "unmeasured"],
)
def test_hover(
    profile: Profile, signal: float, line_px: int, top_mm: float, height_mm: float
) -> None:
    assert profile.touch is not None
    tip = tip_at(320, 288, top_mm)
    assert hover_height(Signal(signal, signal, line_px), tip, profile.touch) == height_mm


@pytest.mark.parametrize(
    ("signal", "pressure", "grams"),
    [(2000.0, 0.02, 25.0), (1800.0, 0.02, 25.0), (2500.0, 0.5, 112.5), (4000.0, 2.0, 375.0)],
)
def test_pressure_and_force(profile: Profile, signal: float, pressure: float, grams: float) -> None:
    assert profile.touch is not None
    assert touch_pressure(signal, profile.touch) == pytest.approx(pressure)
    assert force(pressure, profile.touch) == pytest.approx(grams)


def test_the_drift_of_a_device_that_warms_up_is_followed_past_hand_and_halo() -> None:
    background = Background(
        np.full((576, 640), 500.0, np.float32),
        np.ones((576, 640), np.float32),
        np.ones((576, 640), bool),
    )
    drift = Drift()
    for n in range(0, 30 * 60, 10):
        depth = np.full((576, 640), 506, np.uint16)
        depth[200:400, 200:400] = 450  # a hand that rests
        depth[100:200, 200:400] = 516  # and its halo
        drift = follow_drift(drift, excess_depth(depth, background, drift.offset_mm), n * FRAME_US)
    assert drift.offset_mm == pytest.approx(6.0, abs=0.1)


def test_no_silhouette_is_no_tip() -> None:
    assert silhouette_end(np.zeros((576, 640), bool), (320.0, 288.0), (0.0, -1.0), 7.0) is None
    assert silhouette_end(np.ones((576, 640), bool), (-500.0, 288.0), (0.0, -1.0), 7.0) is None
