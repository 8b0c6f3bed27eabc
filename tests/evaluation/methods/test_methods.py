"""The rivals on a drawn table, where each number is known: a finger that slopes up from its tip."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from halo_service.errors import UserError
from halo_service.evaluation.methods import METHODS, method_named
from halo_service.profile import Profile
from halo_service.runtime.method import Method
from halo_service.sensing import SensingSettings
from halo_service.values import Frame, Touch, TouchFrame, Tracked

FRAME_US = 33_333
SURFACE_MM = 500
SLOPE = 0.7
"""mm that the upper side rises a pixel behind the tip: a pitch of 35 degrees."""
TIP_MM = 3.0
"""How high the upper side begins."""
REACH_MM = 20.0
"""The drawn halo begins at this height."""
TIP = (320, 250)
ON_THE_TIP = (0.0, -6.0)
"""Puts the drawn tracker's landmark, 6 px behind the tip, onto it."""
RIVALS = ("paper", "direct", "wilson")
AIR, DOWN = (30.0, 25.0, 20.0, 15.0), (0.0,) * 6
TAP = (*AIR, *DOWN, *AIR[::-1])

See = Callable[..., Tracked]


def finger(depth: Any, tip: tuple[int, int], height_mm: float) -> None:
    """Draw a finger, and an arm behind it, that points up the image; its halo before its tip."""
    x, y = tip
    if height_mm < REACH_MM:
        dent = 8.0 + 4.0 * (1.0 - height_mm / REACH_MM)
        depth[y - 8 : y, x - 15 : x + 15] = round(SURFACE_MM + dent)
    behind = np.arange(120)
    top = SURFACE_MM - (height_mm + TIP_MM + SLOPE * behind)
    depth[y : y + 120, x - 8 : x + 8] = np.rint(top).astype(np.uint16)[:, None]


def frame_of(height_mm: float, n: int, *tips: tuple[int, int]) -> Frame:
    depth = np.full((576, 640), SURFACE_MM, np.uint16)
    for tip in tips or (TIP,):
        finger(depth, tip, height_mm)
    return Frame(n * FRAME_US, depth, np.zeros((576, 640), np.uint16))


@pytest.fixture
def table(profile: Profile) -> Profile:
    """The four states as the drawn halo reads 10 and 1 mm above the surface, on it, and pressed."""
    assert profile.touch is not None
    signals = {"hover": 10.0, "subtle": 11.0, "touch": 12.0, "pressure": 16.0}
    states = {
        name: replace(getattr(profile.touch, name), signal=240.0 * dent)
        for name, dent in signals.items()
    }
    return replace(profile, touch=replace(profile.touch, **states))


def run(
    method: Method[Any],
    profile: Profile | None,
    see: See,
    heights: Sequence[float],
    *tips: tuple[int, int],
) -> tuple[list[TouchFrame], Any]:
    """One finger, or one at each of `tips`; the hands come a frame late."""
    state = method.start(profile, SensingSettings())
    published = []
    for n, height in enumerate(heights):
        seen = see(TIP, time_us=(n - 1) * FRAME_US, off=ON_THE_TIP) if n else None
        frame, state = method.step(state, frame_of(height, n, *tips), seen)
        published.append(frame)
    return published, state


def kinds(published: Sequence[TouchFrame]) -> list[str]:
    return [event.kind for frame in published for event in frame.events]


@pytest.mark.parametrize("name", RIVALS)
def test_a_tap_is_one_down_and_one_up(name: str, table: Profile, see: See) -> None:
    published, _ = run(METHODS[name], table, see, TAP * 3)
    assert kinds(published) == ["down", "up"] * 3
    (down, *_) = [event for frame in published for event in frame.events]
    assert abs(down.x_mm - (TIP[0] - 319.5 + 150.0)) < 2.0
    assert abs(down.y_mm - (TIP[1] - 287.5 + 100.0)) < 10.0


@pytest.mark.parametrize("name", RIVALS)
def test_a_finger_in_the_air_never_touches(name: str, table: Profile, see: See) -> None:
    published, _ = run(METHODS[name], table, see, (*AIR, *AIR[::-1]) * 3)
    assert kinds(published) == []


@pytest.mark.parametrize("name", RIVALS)
def test_a_clear_ends_the_touch_once(name: str, table: Profile, see: See) -> None:
    method = METHODS[name]
    published, state = run(method, table, see, (*AIR, *DOWN))
    assert published[-1].pointers[0].state is Touch.TOUCH
    cleared, state = method.clear(state, len(published) * FRAME_US)
    assert (kinds([cleared]), cleared.pointers) == (["up"], ())
    again, _ = method.clear(state, (len(published) + 1) * FRAME_US)
    assert kinds([again]) == []


@pytest.mark.parametrize("name", RIVALS)
def test_the_same_frames_give_the_same(name: str, table: Profile, see: See) -> None:
    once, _ = run(METHODS[name], table, see, TAP)
    again, _ = run(METHODS[name], table, see, TAP)
    assert repr(once) == repr(again)


@pytest.mark.parametrize("name", RIVALS)
def test_without_a_profile_there_are_no_pointers(name: str, see: See) -> None:
    published, _ = run(METHODS[name], None, see, TAP)
    assert all(frame.pointers == () and frame.events == () for frame in published)


@pytest.mark.parametrize("name", ("direct", "wilson"))
def test_two_fingers_keep_their_ids(name: str, table: Profile, see: See) -> None:
    published, _ = run(METHODS[name], table, see, DOWN, (250, 250), (390, 260))
    assert {tuple(sorted(each.id for each in frame.pointers)) for frame in published} == {(1, 2)}
    sides = {each.id: each.x_mm < 150.0 for each in published[0].pointers}
    assert all(
        sides[each.id] == (each.x_mm < 150.0) for frame in published for each in frame.pointers
    )


def test_an_unknown_method_lists_the_valid_ones() -> None:
    with pytest.raises(UserError, match="choose from: ours, paper, direct, wilson"):
        method_named("magic")
