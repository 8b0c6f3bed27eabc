"""A hand beyond the image's edge, or nowhere at all, costs its pointer and never the frame."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from halo_service.geometry.surface import Surface
from halo_service.profile import Profile
from halo_service.sensing import SensingSettings, start, step
from halo_service.values import Frame, Hand, Side, Tracked
from tests.drawn import FRAME_US, PER_DENT_MM

Draw = Callable[..., Frame]
See = Callable[..., Tracked]

WIDTH, HEIGHT = 640, 576
EDGES = {
    "left": (-1, 0),
    "right": (1, 0),
    "top": (0, -1),
    "bottom": (0, 1),
    "top left": (-1, -1),
    "top right": (1, -1),
    "bottom left": (-1, 1),
    "bottom right": (1, 1),
}
SWIPE_PX = 1400.0 * FRAME_US / 1e6
"""A frame's way at 1.4 m/s, at 1 px a mm."""
ALL_FINGERS = SensingSettings(fingers="all")


@pytest.fixture(scope="module")
def wide(profile: Profile) -> Profile:
    """A surface of 620 x 480 mm, which reaches near the image's edges."""
    camera_from_surface = np.eye(4)
    camera_from_surface[:3, 3] = (-310.0, -240.0, 500.0)
    states = profile.touch
    assert states is not None
    levels = {"hover": 9, "subtle": 10, "touch": 12, "pressure": 16}
    held = {
        name: replace(getattr(states, name), signal=deep * PER_DENT_MM)
        for name, deep in levels.items()
    }
    surface = Surface("table", 620.0, 480.0, camera_from_surface)
    return replace(profile, surface=surface, touch=replace(states, **held))


def beyond(edge: tuple[int, int], distance_px: float) -> tuple[float, float]:
    """A place so far beyond an edge or a corner; negative: so far inside."""
    return (
        (320.0, WIDTH - 1.0 + distance_px, -distance_px)[edge[0]],
        (288.0, HEIGHT - 1.0 + distance_px, -distance_px)[edge[1]],
    )


@pytest.mark.parametrize("edge", EDGES.values(), ids=EDGES)
def test_a_finger_first_seen_beyond_the_image_is_no_error(
    wide: Profile, draw: Draw, see: See, edge: tuple[int, int]
) -> None:
    for distance_px in [*range(1, 70), *range(70, 301, 10)]:
        tip = beyond(edge, distance_px)
        for settings in (SensingSettings(), ALL_FINGERS):
            frame, _ = step(start(wide, settings), draw(tip, height_mm=20.0), see(tip))
            assert all(np.isfinite([p.x_mm, p.y_mm, p.confidence]).all() for p in frame.pointers)


@pytest.mark.parametrize("distance_px", [1, 20, 50, 53, 60, 120, 300])
@pytest.mark.parametrize("edge", EDGES.values(), ids=EDGES)
def test_a_tracked_finger_seen_beyond_the_image_is_lost_in_the_end(
    wide: Profile, draw: Draw, see: See, edge: tuple[int, int], distance_px: int
) -> None:
    state = start(wide, SensingSettings())
    for n in range(20):
        tip = beyond(edge, -60.0 if n < 3 else distance_px)
        empty = draw((320.0, 3000.0), time_us=n * FRAME_US)
        shown = draw(tip, height_mm=20.0, time_us=n * FRAME_US) if n < 3 else empty
        frame, state = step(state, shown, see(tip, time_us=n * FRAME_US))
        if n == 2:
            assert len(frame.pointers) == 1
    assert frame.pointers == ()


@pytest.mark.parametrize("late", [0, 1, 4])
@pytest.mark.parametrize("edge", EDGES.values(), ids=EDGES)
def test_a_touch_that_swipes_off_the_image_at_1400_mm_s_ends_with_one_up(
    wide: Profile, draw: Draw, see: See, edge: tuple[int, int], late: int
) -> None:
    state = start(wide, SensingSettings())
    tips = [beyond(edge, SWIPE_PX * max(n - 5, 0) - 70.0) for n in range(30)]
    events: list[str] = []
    for n, tip in enumerate(tips):
        time_us = n * FRAME_US
        seen = max(n - late, 0)
        tracked = see(tips[seen], time_us=seen * FRAME_US)
        signal = 12 * PER_DENT_MM if n >= 2 else 0.0
        frame, state = step(state, draw(tip, signal=signal, time_us=time_us), tracked)
        events += [event.kind for event in frame.events]
    assert events == ["down", "up"]
    assert frame.pointers == ()


@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf, 1e7, -1e7, 1e30, -1e300])
@pytest.mark.parametrize(
    "part", [slice(None), 8, 7, 5, 0], ids=["all", "tip", "joint", "root", "wrist"]
)
def test_a_hand_that_is_nowhere_is_no_hand(
    wide: Profile, draw: Draw, see: See, value: float, part: slice | int
) -> None:
    state = start(wide, ALL_FINGERS)
    before, state = step(state, draw(height_mm=20.0), see())
    right = see(time_us=FRAME_US)
    landmarks = right.hands[0].landmarks_px.copy()
    landmarks[part] = value
    wrong = Tracked(FRAME_US, (Hand(Side.RIGHT, landmarks, 0.9),))
    after, state = step(state, draw(height_mm=20.0, time_us=FRAME_US), wrong)
    assert [p.id for p in after.pointers] == [p.id for p in before.pointers]
