"""A whole calibration from one recording and its script, and every bad one refused."""

from __future__ import annotations

import itertools
import json
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import pytest

from halo_calibration.errors import CalibrationError
from halo_calibration.scripted.run import ScriptedCalibration
from halo_calibration.scripted.script import parse_script
from halo_calibration.steps import Setup
from halo_calibration.steps.session import Session
from halo_service.app.cli import main
from halo_service.app.hand_detector import HandDetector
from halo_service.outputs.recorder import Recorder
from halo_service.profile import Profile
from halo_service.profile.store import load
from halo_service.sources import EndOfSource
from halo_service.values import BadFrame, Frame, Tracked
from halo_service.virtual.camera import factory
from halo_service.virtual.offline import frames
from halo_service.virtual.scenarios import start_scenario
from halo_service.virtual.sensor import Sensor
from halo_service.virtual.sim_url import parse_sim_url
from tests.kind_sensor import KIND_URL

pytestmark = pytest.mark.slow

MODE = "NFOV_2X2BINNED"
FPS = factory(mode=MODE).fps
"""A quarter of the pixels: the recording is written and read in a third of the time."""
SIM = parse_sim_url(f"sim:calibration?seed=4&mode={MODE}&{KIND_URL}")
SWEEP_S = 13.6
"""Four of the six rows: enough, and a third less to draw."""
SHORT_SWEEP_S = 5.0
"""A sweep that covers too little."""
BEFORE_S = 0.2
Script = list[dict[str, float | str]]


@pytest.fixture(scope="module")
def script() -> Script:
    scenario = start_scenario(SIM.scenario, SIM.room)
    for second in range(60):
        scenario.at(float(second))
    lines: Script = [
        {"step": step.name, "from_s": step.from_s, "to_s": step.to_s, **step.fields}
        for step in scenario.steps
    ]
    lines[-1]["to_s"] = float(lines[-1]["from_s"]) + SWEEP_S
    return lines


def needed(script: Script, number: int) -> bool:
    """Leave out most of what lies between the steps: it costs time, and belongs to none."""
    at_s = number / FPS
    return any(float(line["from_s"]) - BEFORE_S <= at_s <= float(line["to_s"]) for line in script)


class DrawnRecording(NamedTuple):
    """What the virtual camera sees of the script."""

    path: Path
    """The recording of all of it."""
    frames: list[Frame]
    """Up to the first seconds of the sweep."""


@pytest.fixture(scope="module")
def drawn(script: Script, tmp_path_factory: pytest.TempPathFactory) -> DrawnRecording:
    drawn = DrawnRecording(tmp_path_factory.mktemp("recording") / "calibration.mkv", [])
    seconds = float(script[-1]["to_s"]) + 0.2
    in_memory = float(script[-1]["from_s"]) + SHORT_SWEEP_S + 0.2
    numbers = itertools.count()
    draw = Sensor.frame

    def draw_if_needed(self: Sensor, *arguments: Any) -> Frame | None:
        return draw(self, *arguments) if needed(script, next(numbers)) else None

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(Sensor, "frame", draw_if_needed)
        with Recorder(drawn.path, factory(mode=MODE), fps=FPS, colour=False) as recorder:
            for number, (frame, _) in enumerate(frames(SIM, seconds, colour=False)):
                if frame is None:
                    continue
                recorder.write(frame)
                if number / FPS < in_memory:
                    drawn.frames.append(frame)
    return drawn


def run(drawn: DrawnRecording, script: Script, parent: Path) -> Path:
    """Calibrate with the command, as a user does; return the folder of the profile."""
    folder, written = parent / "desk", parent / "script.json"
    written.write_text(json.dumps(script))
    arguments = ["--source", f"recording:{drawn.path}", "--script", str(written)]
    assert main(["calibrate", *arguments, "--profile", str(folder)]) == 0
    return folder


class Calibrated(NamedTuple):
    """The first calibration from the recording."""

    folder: Path
    hands: dict[int, Tracked]
    """What the real hand tracker found, by `time_us`: looked for once for all tests."""

    def found(self, frame: Frame) -> Tracked:
        return self.hands.get(frame.time_us, Tracked(frame.time_us, ()))


@pytest.fixture(scope="module")
def calibrated(
    drawn: DrawnRecording, script: Script, tmp_path_factory: pytest.TempPathFactory
) -> Calibrated:
    detect, hands = HandDetector.detect, {}

    def remember(self: HandDetector, frame: Frame) -> Tracked:
        return hands.setdefault(frame.time_us, detect(self, frame))

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(HandDetector, "detect", remember)
        return Calibrated(run(drawn, script, tmp_path_factory.mktemp("first")), hands)


def test_the_same_recording_and_script_give_the_same_profile(
    drawn: DrawnRecording,
    script: Script,
    calibrated: Calibrated,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    # That the tracker finds the same hands twice is the test of `halo replay`.
    monkeypatch.setattr(HandDetector, "detect", lambda _, frame: calibrated.found(frame))
    again = run(drawn, script, tmp_path)
    first, second = (
        {path.name: path.read_bytes() for path in folder.iterdir()}
        for folder in (calibrated.folder, again)
    )
    assert first == second
    profile = load(again)
    assert profile.calibrated == "complete"
    assert profile.touch is not None
    signals = [getattr(profile.touch, s).raw for s in ("hover", "subtle", "touch", "pressure")]
    assert signals == sorted(signals)
    assert profile.touch.pressure.stated
    assert profile.correction is not None
    assert profile.correction.base == "virtual"
    assert set(profile.steps) == {"background", "surface", "touch", "sweep"}
    figures = profile.steps["sweep"].figures
    assert figures["variation_corrected"] <= figures["variation_raw"]


class Drawn:
    """A source of frames in memory that loses those of a span of time."""

    kind = "sim"

    def __init__(self, frames: list[Frame], from_s: float, to_s: float) -> None:
        self.camera = factory(mode=MODE)
        first_us = frames[0].time_us
        self._frames = iter(
            [each for each in frames if not from_s <= (each.time_us - first_us) / 1e6 < to_s]
        )

    def read(self, timeout_s: float) -> Frame | BadFrame | None:
        frame = next(self._frames, None)
        if frame is None:
            raise EndOfSource
        return frame

    def close(self) -> None:
        pass


@pytest.fixture
def calibrate(drawn: DrawnRecording, calibrated: Calibrated) -> Callable[..., Profile]:
    def from_memory(script: Script, lost: tuple[float, float] = (0.0, 0.0)) -> Profile:
        source = Drawn(drawn.frames, *lost)
        setup = Setup("desk", source.camera, "2026-01-01T00:00:00Z")
        scripted = ScriptedCalibration(
            setup, Session(source), lambda known: calibrated.found, print
        )
        return scripted.run(parse_script(script, "test"))

    return from_memory


def until(script: Script, last: str) -> Script:
    return script[: [line["step"] for line in script].index(last) + 1]


def test_a_finger_that_moved_is_refused(script: Script, calibrate: Callable[..., Profile]) -> None:
    sweeping = float(script[-1]["from_s"]) + 1.0
    moving: Script = [script[0]]
    for n, state in enumerate(("hover", "subtle", "touch", "pressure")):
        moving.append({"step": state, "from_s": sweeping + 2 * n, "to_s": sweeping + 2 * n + 2})
    with pytest.raises(CalibrationError, match=r"the finger moved by \d+ mm during 'hover': rest"):
        calibrate(moving)


def test_swapped_states_are_refused(script: Script, calibrate: Callable[..., Profile]) -> None:
    lines = [dict(line) for line in until(script, "pressure")]
    lines[1]["step"], lines[2]["step"] = "subtle", "hover"
    with pytest.raises(CalibrationError, match="'hover' shows a stronger halo than 'subtle'"):
        calibrate(lines)


def test_a_hand_in_the_background_is_refused(
    script: Script, calibrate: Callable[..., Profile]
) -> None:
    resting = {**script[0], "from_s": script[3]["from_s"], "to_s": script[3]["to_s"]}
    with pytest.raises(CalibrationError, match=r"a hand was in the camera's view|something moved"):
        calibrate([resting])


def test_two_seconds_of_dropped_frames_are_refused(
    script: Script, calibrate: Callable[..., Profile]
) -> None:
    touch = script[3]
    lost = (float(touch["from_s"]) - 0.2, float(touch["to_s"]) - 0.2)
    with pytest.raises(CalibrationError, match=r"only \d+ of 60 frames came during 'touch'"):
        calibrate(until(script, "pressure"), lost)
    with pytest.raises(CalibrationError, match=r"only \d+ of the 60 frames .* dropped"):
        calibrate(script[:1], (0.4, 2.4))


def test_a_sweep_that_is_too_small_is_refused(
    script: Script, calibrate: Callable[..., Profile]
) -> None:
    lines = [dict(line) for line in script]
    lines[-1]["to_s"] = float(lines[-1]["from_s"]) + SHORT_SWEEP_S
    with pytest.raises(CalibrationError, match=r"covered only \d+ % .* missing most (at|in) the"):
        calibrate(lines)
