"""Frames become touches that begin, move and end; places become pixels; silence is reported."""

from __future__ import annotations

from dataclasses import replace

import pytest

from halo_client import Began, Ended, Moved, PictureTransform, Silence, touches
from halo_protocol import Down, Homography, Lost, Pointer, TouchFrame, Up

FINGER = Pointer(7, 0, 2, 1, 1, 0.5, 0.5, 150.0, 100.0, 0.0, 0.6, 0.0, 0.0, 0.9, 3, -1.0)
DOWN = Down(7, 0, 0.5, 0.5, 180.0, 12.0, 3)
UP = Up(7, 0, 0.5, 0.5, 4.0, 3)
FRAME = TouchFrame("table", "desk", "s1", 41, 1_000_000, (FINGER,))


def test_a_touch_begins_when_the_finger_came_down() -> None:
    (began,) = touches(replace(FRAME, downs=(DOWN,)))
    assert isinstance(began, Began)
    assert began.time_us == 988_000
    assert began.pointer is FINGER


def test_it_moves_in_later_frames_and_ends() -> None:
    (moved,) = touches(FRAME)
    (ended,) = touches(replace(FRAME, pointers=(), ups=(UP,)))
    assert isinstance(moved, Moved)
    assert isinstance(ended, Ended)
    assert moved.key == ended.key
    assert ended.time_us == 996_000


def test_a_tap_within_a_frame_begins_and_ends_though_its_finger_has_gone() -> None:
    began, ended = touches(replace(FRAME, pointers=(), downs=(DOWN,), ups=(UP,)))
    assert isinstance(began, Began) and began.pointer is None
    assert isinstance(ended, Ended) and ended.key == began.key


def test_a_finger_that_strikes_again_ends_its_old_touch_first() -> None:
    found = touches(replace(FRAME, downs=(DOWN,), ups=(replace(UP, contacts=2),)))
    assert [type(touch) for touch in found] == [Ended, Began]


def test_a_hovering_finger_is_no_touch() -> None:
    assert touches(replace(FRAME, pointers=(replace(FINGER, state=0),))) == []


def test_a_window_shows_the_whole_surface_in_its_middle() -> None:
    transform = PictureTransform.fitted(700, 400, 300, 200)
    assert transform.pixel(0, 0) == (50, 0)
    assert transform.pixel(300, 200) == (650, 400)
    assert transform.scale(150, 100) == pytest.approx(2.0)


def test_a_projector_shows_it_through_the_homography() -> None:
    matrix = (5.0, 0.3, 40.0, -0.2, 5.5, 30.0, 1e-4, 2e-4, 1.0)
    homography = Homography("desk", "s1", 0, 1920, 1080, matrix)
    x, y = PictureTransform.projected(homography, 1920, 1080).pixel(100.0, 50.0)
    assert (x, y) == pytest.approx((555 / 1.02, 285 / 1.02))
    half = PictureTransform.projected(homography, 960, 540)
    assert half.pixel(100.0, 50.0) == pytest.approx((x / 2, y / 2))
    assert half.scale(100.0, 50.0) == pytest.approx(5.1 / 2, rel=0.05)


def test_silence_is_reported_once_and_so_is_its_end() -> None:
    silence = Silence("osc://here", 10.0)
    assert silence.notice([], 11.0) is None
    assert str(silence.notice([], 12.5)).startswith("waiting: no frames at osc://here")
    assert silence.notice([], 20.0) is None
    lost = Lost(FRAME.surface, FRAME.node, FRAME.session)
    assert silence.notice([FRAME, lost], 20.5) is None  # the receiver's own frame ends the touches
    assert silence.notice([FRAME], 21.0) == "frames come from osc://here"
    assert silence.notice([FRAME], 22.0) is None
