"""A whole calibration from one recording and its script, and every bad one refused."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from contextlib import closing
from dataclasses import replace
from pathlib import Path

import pytest

from halo_calibration.errors import Refused
from halo_calibration.scripted.run import Scripted
from halo_calibration.scripted.script import parse_script
from halo_calibration.steps import Setup
from halo_calibration.steps.session import Session
from halo_service.app.cli import main
from halo_service.app.hand_detector import HandDetector
from halo_service.outputs.recorder import Recorder
from halo_service.profile import Profile
from halo_service.profile.store import load
from halo_service.settings import Settings
from halo_service.sources import Source
from halo_service.sources.recording import Recording
from halo_service.values import BadFrame, Frame
from halo_service.virtual.camera import FPS, factory
from halo_service.virtual.offline import frames
from halo_service.virtual.scenarios import start_scenario
from halo_service.virtual.sim_url import parse_sim_url

pytestmark = pytest.mark.slow

SIM = parse_sim_url("sim:calibration?seed=4")
SWEEP_S = 13.6
"""Four of the six rows: enough, and a third less to draw."""
BEFORE_S = 0.5
Script = list[dict[str, float | str]]


@pytest.fixture(scope="module")
def script() -> Script:
    acting = start_scenario(SIM.scenario, SIM.room)
    for second in range(60):
        acting.at(float(second))
    lines: Script = [
        {"step": step.name, "from_s": step.from_s, "to_s": step.to_s, **step.fields}
        for step in acting.steps
    ]
    lines[-1]["to_s"] = float(lines[-1]["from_s"]) + SWEEP_S
    return lines


def needed(script: Script, at_s: float) -> bool:
    """Leave out most of what lies between the steps: it costs time, and belongs to none."""
    return any(float(line["from_s"]) - BEFORE_S <= at_s <= float(line["to_s"]) for line in script)


@pytest.fixture(scope="module")
def take(script: Script, tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("take") / "calibration.mkv"
    seconds = float(script[-1]["to_s"]) + 0.2
    with Recorder(path, factory(), fps=FPS, colour=False) as recorder:
        for number, (frame, _) in enumerate(frames(SIM, seconds, colour=False)):
            if frame is not None and needed(script, number / FPS):
                recorder.write(frame)
    return path


def test_the_same_recording_and_script_give_the_same_profile(
    take: Path, script: Script, tmp_path: Path
) -> None:
    written = tmp_path / "script.json"
    written.write_text(json.dumps(script))
    kept = []
    for name in ("one", "two"):
        folder = tmp_path / name / "desk"
        arguments = ["--source", f"recording:{take}", "--script", str(written)]
        assert main(["calibrate", *arguments, "--profile", str(folder)]) == 0
        kept.append({path.name: path.read_bytes() for path in folder.iterdir()})
    assert kept[0] == kept[1]
    profile = load(tmp_path / "one" / "desk")
    assert profile.calibrated == "complete"
    assert profile.touch is not None
    signals = [getattr(profile.touch, s).raw for s in ("hover", "subtle", "touch", "pressure")]
    assert signals == sorted(signals)
    assert profile.touch.pressure.stated
    assert profile.correction is not None
    assert profile.correction.base == "virtual"
    assert set(profile.steps) == {"background", "surface", "touch", "sweep"}
    figures = profile.steps["sweep"].figures
    assert figures["variation_corrected"] < figures["variation_raw"]


class Without:
    """A source that loses what was captured in a span of time."""

    def __init__(self, source: Source, from_s: float, to_s: float) -> None:
        self._source, self._from_s, self._to_s = source, from_s, to_s
        self._first_us: int | None = None
        self.kind, self.camera = source.kind, source.camera

    def read(self, timeout_s: float) -> Frame | BadFrame | None:
        while True:
            capture = self._source.read(timeout_s)
            assert capture is not None
            self._first_us = capture.time_us if self._first_us is None else self._first_us
            if not self._from_s <= (capture.time_us - self._first_us) / 1e6 < self._to_s:
                return capture

    def close(self) -> None:
        self._source.close()


@pytest.fixture
def calibrate(take: Path) -> Iterator[Callable[..., Profile]]:
    def run(script: Script, lost: tuple[float, float] = (0.0, 0.0)) -> Profile:
        settings = Settings()
        with closing(Without(Recording(take, realtime=False, loop=False), *lost)) as source:
            eyes = HandDetector(source.camera, None, replace(settings.tracking, max_hands=1))
            try:
                setup = Setup("desk", source.camera, "2026-01-01T00:00:00Z")
                scripted = Scripted(setup, Session(source), lambda known: eyes.look, print)
                return scripted.run(parse_script(script, "test"))
            finally:
                eyes.close()

    yield run


def until(script: Script, last: str) -> Script:
    return script[: [line["step"] for line in script].index(last) + 1]


def test_a_finger_that_moved_is_refused(script: Script, calibrate: Callable[..., Profile]) -> None:
    sweeping = float(script[-1]["from_s"]) + 1.0
    moving: Script = [script[0]]
    for n, state in enumerate(("hover", "subtle", "touch", "pressure")):
        moving.append({"step": state, "from_s": sweeping + 2 * n, "to_s": sweeping + 2 * n + 2})
    with pytest.raises(Refused, match=r"the finger moved by \d+ mm during 'hover': rest"):
        calibrate(moving)


def test_swapped_states_are_refused(script: Script, calibrate: Callable[..., Profile]) -> None:
    lines = [dict(line) for line in until(script, "pressure")]
    lines[1]["step"], lines[2]["step"] = "subtle", "hover"
    with pytest.raises(Refused, match="'hover' shows a stronger halo than 'subtle'"):
        calibrate(lines)


def test_a_hand_in_the_background_is_refused(
    script: Script, calibrate: Callable[..., Profile]
) -> None:
    resting = {**script[0], "from_s": script[3]["from_s"], "to_s": script[3]["to_s"]}
    with pytest.raises(Refused, match=r"a hand was in the camera's view|something moved"):
        calibrate([resting])


def test_two_seconds_of_dropped_frames_are_refused(
    script: Script, calibrate: Callable[..., Profile]
) -> None:
    touch = script[3]
    lost = (float(touch["from_s"]) - 0.2, float(touch["to_s"]) - 0.2)
    with pytest.raises(Refused, match=r"only \d+ of 60 frames came during 'touch'"):
        calibrate(until(script, "pressure"), lost)
    with pytest.raises(Refused, match=r"only \d+ of the 60 frames .* dropped"):
        calibrate(script[:1], (0.4, 2.4))


def test_a_sweep_that_is_too_small_is_refused(
    script: Script, calibrate: Callable[..., Profile]
) -> None:
    lines = [dict(line) for line in script]
    lines[-1]["to_s"] = float(lines[-1]["from_s"]) + 5.0
    with pytest.raises(Refused, match=r"covered only \d+ % .* missing most (at|in) the"):
        calibrate(lines)
