"""Marks are touched and boards are shown as the prompts say."""

from __future__ import annotations

import logging
import re
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from halo_calibration.boards.board import crosses
from halo_calibration.errors import CalibrationError
from halo_calibration.guided import place as guided_place
from halo_calibration.guided import projector as guided_projector
from halo_calibration.guided.guide import GuidedCalibration, Prompt
from halo_calibration.guided.place import GuidedPlace
from halo_calibration.guided.projector import GuidedProjector
from halo_calibration.steps import Setup
from halo_calibration.steps.session import Session
from halo_service.app.virtual_user.user import VirtualUser
from halo_service.geometry.camera import Camera
from halo_service.profile import Profile
from halo_service.values import Frame, Tracked
from halo_service.virtual.room import Room

CORNERS_PX = ((200.0, 220.0), (440.0, 220.0), (440.0, 380.0), (200.0, 380.0))
SIZE = (1280, 800)
NEARER = (500.0 - 8.0) / 500.0
"""The middle of a drawn finger's round tip is seen 8 mm above the table: a radius of 7, and the
millimetre by which the finger is thicker than one that was not measured."""
DOWN, UP = 9, 4
"""Frames of a touch, and between two."""
FRAME_US = 66_667
"""15 frames a second: half as many to sense as 30."""


class Person:
    """A drawn source and a `Guide` at once: a finger that touches the mark of the prompt."""

    kind = "camera"

    def __init__(
        self, camera: Camera, draw, see, place_of: Callable[[Prompt], tuple[float, float]]
    ):
        self.camera = replace(camera, fps=15)
        self.said: list[str] = []
        self.prompts: list[Prompt] = []
        self.sloppy_px = 0.0
        """How far from the mark the next mark's last touch goes."""
        self._draw, self._see, self._place_of = draw, see, place_of
        self._number = 0
        self._tip = (320.0, 300.0)
        self._coming: list[tuple[tuple[float, float], bool]] = []

    def prompt(self, prompt: Prompt) -> None:
        self.prompts.append(prompt)
        x, y = self._place_of(prompt)
        # The finger still rests on the mark before when the next is named.
        rests = len(self.prompts) > 1
        self._coming = [(self._tip, True)] * DOWN * rests + [(self._tip, False)] * UP
        for off in (0.0, 0.0, self.sloppy_px):
            self._coming += [((x + off, y), True)] * DOWN + [((x + off, y), False)] * UP
        self.sloppy_px = 0.0

    def say(self, words: str) -> None:
        self.said.append(words)

    def live(self, seconds_left, measuring, seen) -> None:
        """Show nothing: there is no screen."""

    def map(self, lines) -> None:
        """Nothing to map."""

    def read(self, timeout_s: float) -> Frame:
        self._number += 1
        down = False
        if self._coming:
            self._tip, down = self._coming.pop(0)
        time_us = self._number * FRAME_US
        height_mm = 0.0 if down else 40.0
        return self._draw(self._tip, 3600.0 if down else 0.0, height_mm, time_us)

    def detect(self, frame: Frame) -> Tracked:
        return self._see(self._tip, frame.time_us)

    def close(self) -> None:
        """Nothing to let go."""


def guided(person: Person) -> GuidedCalibration:
    setup = Setup("desk", person.camera, "2026-01-01T00:00:00Z")
    return GuidedCalibration(setup, Session(person), person, lambda profile: person.detect)


def test_four_touched_corners_make_a_surface(camera, draw, see, profile: Profile) -> None:
    person = Person(camera, draw, see, lambda prompt: CORNERS_PX[prompt.number])
    made = GuidedPlace(guided(person)).corners(profile)(profile)
    assert [prompt.name for prompt in person.prompts] == ["corner"] * 4
    assert made.surface.width_mm == pytest.approx(240.0 * NEARER, abs=1.0)
    assert made.surface.height_mm == pytest.approx(160.0 * NEARER, abs=1.0)
    assert "error_mm" in made.steps["surface"].figures


def test_a_mark_whose_touches_differ_is_asked_for_again(camera, draw, see, profile) -> None:
    person = Person(camera, draw, see, lambda prompt: CORNERS_PX[prompt.number])
    person.sloppy_px = 20.0
    GuidedPlace(guided(person)).corners(profile)
    assert [prompt.number for prompt in person.prompts] == [0, 0, 1, 2, 3]
    assert sum("mm apart" in words for words in person.said) == 1


class Screen:
    """Stores what it should show."""

    def __init__(self, changes: bool = True) -> None:
        self.size_px = SIZE
        self.changes = changes
        self.shown: list[np.ndarray] = []

    def show(self, picture) -> None:
        self.shown.append(picture)


def test_nine_touched_crosses_make_a_homography(
    camera, draw, see, profile: Profile, caplog: pytest.LogCaptureFixture
) -> None:
    caplog.set_level(logging.DEBUG, "halo_calibration")

    def under(prompt: Prompt) -> tuple[float, float]:
        return 190.0 + prompt.at_px[0] / 5.0, 210.0 + prompt.at_px[1] / 5.0

    person, screen = Person(camera, draw, see, under), Screen()
    made = GuidedProjector(guided(person), screen).projector(profile, "touch")(profile)
    assert made.projector is not None
    for scale in np.diag(made.projector.projector_from_surface)[:2]:
        assert scale == pytest.approx(5.0 / NEARER, rel=0.01)
    logged = [message for message in caplog.messages if "cross: off by" in message]
    assert len(logged) == 9
    assert all(re.search(r"[0-9.]+ px, [0-9.]+ mm$", message) for message in logged)
    assert len(screen.shown) == 10
    for picture, (x, y) in zip(screen.shown, crosses(*SIZE), strict=False):
        assert picture[round(y), round(x)].min() == 255  # the one to touch is the bright one
        assert np.count_nonzero(picture == 255) < np.count_nonzero(picture) / 4
    assert not screen.shown[-1].any()  # dark in the end


def test_a_file_shows_all_crosses_at_once_and_no_stripes(camera, draw, see, profile) -> None:
    person, screen = Person(camera, draw, see, lambda prompt: (300.0, 300.0)), Screen(changes=False)
    projector = GuidedProjector(guided(person), screen)
    with pytest.raises(CalibrationError, match="one after the other"):
        projector.projector(profile, "gray")
    assert not screen.shown


@pytest.mark.slow
def test_a_board_is_exposed_for_and_found_in_a_dim_room(monkeypatch) -> None:
    """Left to itself the camera exposes for the room, and the board is blown out."""
    monkeypatch.setattr(guided_place, "READY_S", 0.1)
    monkeypatch.setattr(guided_projector, "LOOK_S", 0.2)
    monkeypatch.setattr(guided_projector, "SETTLE_S", 0.05)
    user = VirtualUser(Room(seed=201, light=0.15), colour_times=1)
    screen = Screen()
    screen.size_px, screen.show = user.projector_px, user.project
    person = Person(user.camera, None, None, lambda prompt: (0.0, 0.0))
    setup = Setup("desk", user.camera, "2026-01-01T00:00:00Z")
    guide = GuidedCalibration(
        setup, Session(user), person, lambda p: lambda f: Tracked(f.time_us, ())
    )
    profile = guide.background()(None)
    made = GuidedProjector(guide, screen, user.expose).projector(profile, "markers")(profile)
    assert any(words.startswith("Exposure: ") for words in person.said)
    assert made.steps["projector"].figures["error_px"] < 0.5
