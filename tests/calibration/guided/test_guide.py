"""A person who does not follow a prompt gets it again."""

from __future__ import annotations

import numpy as np
import pytest

from halo_calibration.errors import CalibrationError
from halo_calibration.guided.guide import ATTEMPTS, GuidedCalibration, Prompt
from halo_calibration.observe import Observation
from halo_calibration.steps import Setup
from halo_calibration.steps.session import Session
from halo_service.geometry.camera import Camera, Lens
from halo_service.values import Frame, Tracked

SHAPE = (144, 160)
CAMERA = Camera(
    "A1",
    "NFOV_UNBINNED",
    30,
    Lens(SHAPE[1], SHAPE[0], 125.0, 125.0, 79.5, 71.5),
    None,
    np.eye(4),
)


class Table:
    """A drawn source: a noisy flat table, and a hand that is waved over it on demand."""

    kind = "camera"
    camera = CAMERA

    def __init__(self) -> None:
        self._number = 0
        self.waving = False

    def read(self, timeout_s: float) -> Frame:
        self._number += 1
        rng = np.random.default_rng(self._number)
        depth = np.rint(rng.normal(500.0, 1.0, SHAPE)).astype(np.uint16)
        if self.waving:
            at = self._number % 60
            depth[40:80, 20 + at : 60 + at] = 430
        return Frame(self._number * 33_333, depth, depth)

    def close(self) -> None:
        """Nothing to let go."""


class Person:
    """A `Guide` who waves for a number of attempts."""

    def __init__(self, table: Table, waves: int) -> None:
        self._table, self._waves = table, waves
        self.said: list[str] = []
        self.prompts = 0
        self.counted_down: list[float] = []

    def prompt(self, prompt: Prompt) -> None:
        self.prompts += 1
        self._table.waving = self.prompts <= self._waves

    def say(self, words: str) -> None:
        self.said.append(words)

    def live(self, seconds_left: float, measuring: bool, seen: Observation | None) -> None:
        if not measuring:
            self.counted_down.append(seconds_left)

    def map(self, lines: list[str]) -> None:
        raise AssertionError("the background has no map")


def no_hands(frame: Frame) -> Tracked:
    return Tracked(frame.time_us, ())


def guided(waves: int) -> tuple[GuidedCalibration, Person]:
    table = Table()
    person = Person(table, waves)
    setup = Setup("desk", CAMERA, "2026-01-01T00:00:00Z")
    return GuidedCalibration(setup, Session(table), person, lambda profile: no_hands), person


def test_a_refused_step_is_done_again_with_a_count_down() -> None:
    steps, person = guided(waves=1)
    profile = steps.background()(None)
    assert person.prompts == 2
    assert len(person.said) == 1
    assert "something moved" in person.said[0]
    assert profile.steps["background"].quality == "good"
    assert profile.steps["surface"].figures["residual_mm"] < 0.5
    first = person.counted_down[: len(person.counted_down) // 2]
    assert first == sorted(first, reverse=True)
    assert first[0] == pytest.approx(3.0)


def test_after_three_attempts_the_sentence_is_final() -> None:
    steps, person = guided(waves=9)
    with pytest.raises(CalibrationError, match="something moved"):
        steps.background()
    assert person.prompts == ATTEMPTS
