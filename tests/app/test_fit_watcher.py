"""The service notices that a profile no longer fits, says so, and notices that it fits again."""

from __future__ import annotations

import time
from dataclasses import replace

import cv2
import numpy as np
import pytest

from halo_calibration.base_model import VIRTUAL, choose_base, read_base
from halo_calibration.boards.board import anchor, marker_squares
from halo_service.app.service.fit_watcher import (
    HIDDEN_IN_A_ROW,
    IN_A_ROW,
    FitJudge,
    FitWatcher,
    marker_off_mm,
    watched,
)
from halo_service.profile import Anchor, Profile
from halo_service.profile.store import require_fit
from halo_service.sensing.fit import surface_fit
from halo_service.values import Frame, Tracked
from halo_service.virtual.sensor import Sensor
from halo_service.virtual.sim_url import parse_sim_url
from tests.drawn import VIEWS, DrawnTable

ROWS, COLUMNS = np.mgrid[:576, :640]


def shown(
    table: DrawnTable, moved_mm: float = 0.0, tilted_deg: float = 0.0, hidden: float = 0.0
) -> np.ndarray:
    """A table that was moved and tilted, with hands over a share of the picture."""
    height, width = table.shape
    noise = np.random.default_rng(1).normal(0.0, 1.5, table.shape)
    x = (COLUMNS[:height, :width] - table.lens.cx) / table.lens.fx
    depth = table.distance_mm + moved_mm + noise
    depth += table.distance_mm * np.tan(np.radians(tilted_deg)) * x
    depth[: round(hidden * height)] -= 60.0
    return np.rint(depth).astype(np.uint16)


CASES = {
    "as calibrated": ({}, "good"),
    "warmed up": ({"moved_mm": 4.0}, "good"),
    "two arms over it": ({"hidden": 0.4}, "good"),
    "two arms over a device that warmed up": ({"moved_mm": 4.0, "hidden": 0.4}, "good"),
    "tilted by 1 degree": ({"tilted_deg": 1.0}, "tilted"),
    "tilted by 1 degree, under two arms": ({"tilted_deg": -1.0, "hidden": 0.3}, "tilted"),
    "tilted by 3 degrees": ({"tilted_deg": 3.0}, "tilted"),
    "table lowered": ({"moved_mm": 15.0}, "moved"),
    "table raised": ({"moved_mm": -15.0}, "moved"),
    "another table": ({"moved_mm": 120.0}, "moved"),
    "a board on it": ({"hidden": 0.55}, "moved"),
}


@pytest.mark.parametrize("view", VIEWS)
@pytest.mark.parametrize("case", CASES)
def test_the_state_of_the_fit(view: str, case: str) -> None:
    table, (change, state) = VIEWS[view], CASES[case]
    judge = FitJudge()
    changes = [judge.see(table.profile, shown(table, **change), None) for _ in range(IN_A_ROW)]
    assert judge.fit == state
    assert changes == [False] * (IN_A_ROW - 1) + [True]
    assert bool(judge.reason) == (state != "good")
    assert ("halo calibrate background" in judge.reason) == (state != "good")


def test_a_picture_without_the_table_is_hidden_after_a_while() -> None:
    table, judge = VIEWS["500 mm"], FitJudge()
    clutter = np.random.default_rng(2).integers(300, 900, table.shape).astype(np.uint16)
    for _ in range(HIDDEN_IN_A_ROW - 1):
        judge.see(table.profile, clutter, None)
    assert judge.fit == "unknown"
    judge.see(table.profile, np.zeros(table.shape, np.uint16), None)
    assert judge.fit == "hidden"


def test_a_new_profile_is_judged_anew() -> None:
    table, judge = VIEWS["500 mm"], FitJudge()
    for _ in range(IN_A_ROW):
        judge.see(table.profile, shown(table, tilted_deg=2.0), None)
    assert judge.fit == "tilted"
    background = replace(
        table.profile.background, mean_mm=shown(table, tilted_deg=2.0).astype(np.float32)
    )
    again = replace(table.profile, background=background)
    for _ in range(IN_A_ROW):
        judge.see(again, shown(table, tilted_deg=2.0), None)
    assert (judge.fit, judge.reason) == ("good", "")


@pytest.mark.parametrize("turn_deg", [0.0, 30.0])
@pytest.mark.parametrize("off_mm", [0.0, 12.0])
def test_a_marker_that_was_moved_is_noticed(off_mm: float, turn_deg: float) -> None:
    table = VIEWS["500 mm"]
    board = anchor("apriltag-36h11", 0, 80.0)
    side, squares = 10, np.pad(marker_squares(board.family, 0), 1)
    sheet = cv2.resize(
        np.where(squares, 0, 255).astype(np.uint8), None, fx=side, fy=side, interpolation=0
    )
    # The sheet's middle is over the surface's middle: 1 px is 1 mm.
    turn = np.radians(turn_deg)
    rotation = np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]])
    centre = np.array([table.lens.cx + off_mm, table.lens.cy])
    shift = centre - rotation @ np.full(2, (sheet.shape[0] - 1) / 2.0)
    picture = cv2.warpAffine(
        sheet, np.column_stack([rotation, shift]), table.shape[::-1], borderValue=255
    )
    picture = np.asarray(cv2.GaussianBlur(picture, (5, 5), 1.0))
    surface_from_anchor = np.eye(4)
    surface_from_anchor[:2, :2] = rotation
    surface_from_anchor[:2, 3] = (150.0, 100.0)
    camera = replace(table.camera, colour=table.lens)
    profile = replace(
        table.profile,
        camera=camera,
        anchor=Anchor("apriltag-36h11", 0, 80.0, np.linalg.inv(surface_from_anchor)),
    )
    assert marker_off_mm(profile, picture) == pytest.approx(off_mm, abs=0.5)
    judge = FitJudge()
    for _ in range(IN_A_ROW):
        judge.see(profile, shown(table), picture)
    assert judge.fit == ("marker" if off_mm else "good")
    assert marker_off_mm(profile, np.full_like(picture, 255)) is None


def test_a_running_service_warns_once_and_says_when_it_fits_again(
    caplog: pytest.LogCaptureFixture,
) -> None:
    table = VIEWS["500 mm"]
    profile: Profile = table.profile
    watcher = FitWatcher(lambda: profile)
    time_us = 0

    def watch_until(state: str, depth: np.ndarray) -> None:
        nonlocal time_us
        until = time.monotonic() + 10.0
        while watcher.fit != state and time.monotonic() < until:
            time_us += 1_000_000
            watcher.watch(Frame(time_us, depth, depth))
            time.sleep(0.02)
        assert watcher.fit == state

    try:
        watch_until("good", shown(table))
        watch_until("tilted", shown(table, tilted_deg=1.0))
        watch_until("good", shown(table))
    finally:
        watcher.close()
    said = [each.getMessage() for each in caplog.records]
    assert len(said) == 2
    assert "'drawn' does not fit" in said[0]
    assert "tilted by 1.0 degrees" in said[0]
    assert "fits again" in said[1]


def profile_of(room: str) -> tuple[Profile, Sensor]:
    sensor = Sensor(parse_sim_url(room).room, colour_times=0)
    empty = sensor.frame(0, [], []).depth
    background = replace(
        VIEWS["500 mm"].profile.background,
        mean_mm=empty.astype(np.float32),
        valid=empty > 0,
    )
    return Profile("room", sensor.camera, sensor.surface, background, None, 1), sensor


def test_each_virtual_room_has_its_own_serial() -> None:
    profile, _ = profile_of("sim:idle?seed=3&material=paper")
    same = parse_sim_url("sim:demo?seed=3&material=paper&camera_pitch_deg=2").room.camera()
    require_fit(profile, same)
    for other in ("sim:demo?seed=4&material=paper", "sim:demo?seed=3&material=foam"):
        with pytest.raises(Exception, match="belongs to camera VIRTUAL-0001-3-paper"):
            require_fit(profile, parse_sim_url(other).room.camera())


def test_every_virtual_kinect_has_the_virtual_base_model_and_no_other_camera_has_it() -> None:
    def found(source: str) -> object:
        base = choose_base("auto", parse_sim_url(source).room.camera().serial)
        return base and base.name

    name = read_base(VIRTUAL).name
    assert {found(f"sim:demo?seed={seed}") for seed in (1, 2, 901)} == {name}
    assert found("sim:demo?device=bolt") is None
    assert choose_base("auto", "000123") is None


@pytest.mark.parametrize(
    ("change", "good"),
    [("", True), ("&camera_pitch_deg=1.8", False), ("&camera_height_mm=560", False)],
)
def test_a_moved_virtual_camera_does_not_fit(change: str, good: bool) -> None:
    room = "sim:idle?seed=3&material=paper&camera_height_mm=500&camera_pitch_deg=0.8"
    profile, _ = profile_of(room)
    _, sensor = profile_of(room + change)
    assert surface_fit(sensor.frame(33_333, [], []).depth, profile).good == good


def test_a_recording_that_the_profile_does_not_fit_is_warned_of_once(
    caplog: pytest.LogCaptureFixture,
) -> None:
    table = VIEWS["500 mm"]
    look = watched(lambda frame: Tracked(frame.time_us, ()), table.profile)
    for change in ({}, {"tilted_deg": 3.0}):
        depth = shown(table, **change)
        for n in range(300):
            assert look(Frame(n * 33_333, depth, depth)).time_us == n * 33_333
        look = watched(lambda frame: Tracked(frame.time_us, ()), table.profile)
    (said,) = [each.getMessage() for each in caplog.records]
    assert "'drawn' does not fit: the surface is" in said
