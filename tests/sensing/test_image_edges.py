"""A hand beyond the image's edge, or nowhere at all, costs its pointer and never the frame."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from halo_service.sensing import SensingSettings, start, step
from halo_service.values import Hand, Side, Tracked
from tests.drawn import FRAME_US, DrawnTable, Pair, pointing

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
SWIPE_MM = 1400.0 * FRAME_US / 1e6
"""A frame's way at 1.4 m/s."""
TOUCHES = 12
"""Depth of the dent, mm."""
ALL_FINGERS = SensingSettings(fingers="all")


@pytest.fixture(scope="module")
def wide(table: DrawnTable) -> DrawnTable:
    """A surface that reaches beyond the image, so that a pointer may be anywhere in it."""
    size_mm = (1.5 * each / table.px_per_mm for each in (table.lens.width, table.lens.height))
    return replace(table, surface_mm=tuple(size_mm))


def beyond(table: DrawnTable, edge: tuple[int, int], distance_px: float) -> Pair:
    """Return the pixel so far beyond an edge or a corner; negative: so far inside."""
    height, width = table.shape
    return (
        (width / 2.0, width - 1.0 + distance_px, -distance_px)[edge[0]],
        (height / 2.0, height - 1.0 + distance_px, -distance_px)[edge[1]],
    )


@pytest.mark.parametrize("edge", EDGES.values(), ids=EDGES)
def test_a_finger_first_seen_beyond_the_image_is_no_error(
    wide: DrawnTable, edge: tuple[int, int]
) -> None:
    for distance_px in [1, 10, 30, *range(46, 60), 75, 105, 150, 300]:
        tip = beyond(wide, edge, distance_px)
        shown = wide.painted(tip, wide.px_per_mm, 0.0, 20.0, 0)
        hands = pointing(tip, wide.px_per_mm, 0)
        for settings in (SensingSettings(), ALL_FINGERS):
            frame, _ = step(start(wide.profile, settings), shown, hands)
            assert all(np.isfinite([p.x_mm, p.y_mm, p.confidence]).all() for p in frame.pointers)


@pytest.mark.parametrize("distance_px", [1, 20, 50, 53, 60, 120, 300])
@pytest.mark.parametrize("edge", EDGES.values(), ids=EDGES)
def test_a_tracked_finger_seen_beyond_the_image_is_lost_in_the_end(
    wide: DrawnTable, edge: tuple[int, int], distance_px: int
) -> None:
    state = start(wide.profile, SensingSettings())
    for n in range(13):
        tip = beyond(wide, edge, -60.0 if n < 3 else distance_px)
        drawn = tip if n < 3 else (320.0, 3000.0)
        shown = wide.painted(drawn, wide.px_per_mm, 0.0, 20.0, n * FRAME_US)
        frame, state = step(state, shown, pointing(tip, wide.px_per_mm, n * FRAME_US))
        if n == 2:
            assert len(frame.pointers) == 1
    assert frame.pointers == ()


@pytest.mark.parametrize("late", [0, 1, 4])
@pytest.mark.parametrize("edge", EDGES.values(), ids=EDGES)
def test_a_touch_that_swipes_off_the_image_at_1400_mm_s_ends_with_one_up(
    wide: DrawnTable, edge: tuple[int, int], late: int
) -> None:
    state = start(wide.profile, SensingSettings())
    swipe_px, scale = SWIPE_MM * wide.px_per_mm, wide.px_per_mm
    tips = [beyond(wide, edge, swipe_px * max(n - 5, 0) - 70.0) for n in range(22)]
    events: list[str] = []
    for n, tip in enumerate(tips):
        seen = max(n - late, 0)
        hands = pointing(tips[seen], scale, seen * FRAME_US)
        dent_mm = TOUCHES if n >= 2 else 0.0
        frame, state = step(state, wide.painted(tip, scale, dent_mm, 0.0, n * FRAME_US), hands)
        events += [event.kind for event in frame.events]
    assert events == ["down", "up"]
    assert frame.pointers == ()


@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf, 1e7, -1e7, 1e30, -1e300])
@pytest.mark.parametrize(
    "part", [slice(None), 8, 7, 5, 0], ids=["all", "tip", "joint", "root", "wrist"]
)
def test_a_hand_that_is_nowhere_is_no_hand(
    table: DrawnTable, value: float, part: slice | int
) -> None:
    state = start(table.profile, ALL_FINGERS)
    before, state = step(state, table.frame(height_mm=20.0), table.hands())
    landmarks = table.hands().hands[0].landmarks_px.copy()
    landmarks[part] = value
    wrong = Tracked(FRAME_US, (Hand(Side.RIGHT, landmarks, 0.9),))
    after, state = step(state, table.frame(height_mm=20.0, time_us=FRAME_US), wrong)
    assert [p.id for p in after.pointers] == [p.id for p in before.pointers]
