"""Surface, projector and anchor of one recording and its script, against the room's truth."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from halo_calibration.boards.board import ANCHOR, SHEET
from halo_calibration.guided.guide import PROMPTS, Prompt
from halo_service.app.cli import main
from halo_service.app.virtual_user.user import MARKER_AT, SHEET_AT
from halo_service.outputs.recorder import Recorder
from halo_service.profile import Profile
from halo_service.profile.store import load
from halo_service.virtual.camera import factory
from halo_service.virtual.room import Room, draw_room
from tests.filmed import Film

pytestmark = pytest.mark.slow

FRAMES = 12
"""Of each board: 0.4 seconds."""


@pytest.fixture(scope="module")
def room() -> Room:
    return draw_room(201, exposure_ms=4.0)


@pytest.fixture(scope="module")
def recording(room: Room, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A recording; its script and the profile made of both are in its folder."""
    folder = tmp_path_factory.mktemp("place")
    recording = folder / "place.mkv"
    with Recorder(recording, factory(), fps=factory().fps, colour=True) as recorder:
        film = Film(room, recorder)
        film.user.follow(PROMPTS["background"])
        film.step("background", 60)
        film.user.follow(Prompt("sheet", "", board=SHEET))
        film.step("surface", FRAMES, by="markers", width_mm=280.0)
        film.board(FRAMES)
        film.user.follow(Prompt("marker", "", board=ANCHOR))
        (number,) = ANCHOR.middles_mm
        film.step("anchor", FRAMES, marker=number)
    script = film.written(folder)
    arguments = ["--source", f"recording:{recording}", "--script", str(script)]
    assert main(["calibrate", *arguments, "--profile", str(folder / "profile")]) == 0
    return recording


@pytest.fixture(scope="module")
def profile(recording: Path) -> Profile:
    return load(recording.with_name("profile"))


def on_sheet(at: tuple[float, float, float], places: np.ndarray) -> np.ndarray:
    """(N, 3) on the room's surface from (N, 2) mm around the middle of what lies there."""
    turn = np.radians(at[2])
    rotation = np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]])
    return np.column_stack([places @ rotation.T + at[:2], np.zeros(len(places))])


def seen_from(room: Room, profile: Profile, points: np.ndarray) -> np.ndarray:
    """(N, 3) of the room's surface in the calibrated one's frame."""
    return profile.surface.from_camera(room.surface().to_camera(points))


def test_the_surface_lies_around_the_sheet(room: Room, profile: Profile) -> None:
    surface = profile.surface
    assert (surface.width_mm, surface.height_mm) == (280.0, 200.0)
    half = np.array([[-140.0, -100.0], [140.0, -100.0], [140.0, 100.0], [-140.0, 100.0]])
    corners = seen_from(room, profile, on_sheet(SHEET_AT, half))
    off = np.linalg.norm(corners[:, :2] - (half + np.array([140.0, 100.0])), axis=1)
    print(f"surface: corners off by {off.max():.2f} mm")
    assert off.max() < 1.5
    assert profile.steps["surface"].figures["error_mm"] < 1.0


def test_what_is_touched_is_where_it_is_projected(room: Room, profile: Profile) -> None:
    """A finger that truly rests on a projected target is reported within 1.5 mm of it."""
    assert profile.projector is not None
    matrix = np.linalg.inv(profile.projector.projector_from_surface)
    truth = np.linalg.inv(room.projector.projector_from_surface())
    targets = np.array([(x, y) for x in (300.0, 640.0, 980.0) for y in (200.0, 400.0, 600.0)])

    def on_table(back: np.ndarray) -> np.ndarray:
        places = np.column_stack([targets, np.ones(len(targets))]) @ back.T
        return places[:, :2] / places[:, 2:]

    lit = np.column_stack([on_table(truth), np.zeros(len(targets))])
    off = np.linalg.norm(seen_from(room, profile, lit)[:, :2] - on_table(matrix), axis=1)
    print(f"projector: targets off by {off.mean():.2f} mm, {off.max():.2f} at most")
    assert off.max() < 1.5


def test_the_anchor_is_where_the_marker_lies(room: Room, profile: Profile) -> None:
    assert profile.anchor is not None
    square = np.array([[-40.0, -40.0], [40.0, -40.0], [40.0, 40.0], [-40.0, 40.0]])
    corners = seen_from(room, profile, on_sheet(MARKER_AT, square))
    moved = np.column_stack([corners, np.ones(4)]) @ profile.anchor.anchor_from_surface.T
    off = np.linalg.norm(moved[:, :2] - square, axis=1)
    print(f"anchor: corners off by {off.max():.2f} mm")
    assert off.max() < 2.0


def test_a_recording_can_be_verified_too(
    recording: Path,
    profile: Profile,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    """No touch is in it, and the command says so at its end."""
    monkeypatch.setenv("SDL_VIDEODRIVER", "dummy")
    source = ["--source", f"recording:{recording}", "--profile", str(recording.parent / "profile")]
    assert main(["verify", *source, "--window"]) == 1
    assert "no crossing was touched" in capsys.readouterr().out
