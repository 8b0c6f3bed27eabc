"""The session follows the finger: what is prompted, recorded and written into the script."""

from __future__ import annotations

import wave
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from halo_calibration.guided.guide import Prompt
from halo_calibration.observe import Observation
from halo_service.app.cli import main
from halo_service.app.first_light.announce import PAGE, Announcer, page_of, write_tone
from halo_service.app.first_light.plan import PlanOptions, tasks_of
from halo_service.app.first_light.session import AWAY, Cutter, follow_tasks
from halo_service.app.recordings.area import near_surface
from halo_service.errors import UserError
from halo_service.geometry.surface import Surface
from halo_service.profile import Profile
from halo_service.values import Frame
from halo_service.virtual.scenarios.study import targets
from tests.app.first_light.test_pace import FRAME_US, TOUCH_RAW, at

SURFACE = Surface("table", 300.0, 200.0, np.eye(4))
PIXEL = np.ones((2, 2), np.uint16)
UNIX_US = 1_700_000_000_000_000


def test_the_session_has_the_papers_targets_heights_and_forces() -> None:
    tasks = list(tasks_of(SURFACE, PlanOptions()))
    steps = [task.step for task in tasks]
    assert {name: steps.count(name) for name in steps} == {
        "target": 32,
        "hover": 10,
        "pressure": 10,
    }
    places = [tuple(task.fields["target_mm"]) for task in tasks if task.step == "target"]
    assert places == 2 * targets()
    assert [task.prompt.at_mm for task in tasks[:32]] == places
    brief = list(tasks_of(SURFACE, PlanOptions(brief=True)))
    assert len(brief) == 12


def test_coins_and_no_scale_change_the_tasks_and_wrong_levels_are_refused() -> None:
    tasks = list(tasks_of(SURFACE, PlanOptions((4.7, 9.3), coins=True, forces_g=())))
    levels = [task for task in tasks if task.step != "target"]
    assert [task.fields for task in levels] == [{"height_mm": 4.7}, {"height_mm": 9.3}] * 2
    assert "coins, 4.7 mm high" in levels[0].prompt.words
    with pytest.raises(UserError, match=r"range 0\.5\.\.40 mm"):
        PlanOptions((0.0,))
    with pytest.raises(UserError, match=r"range 10\.\.1000 g"):
        PlanOptions(forces_g=(5000.0,))


class Finger:
    """A person who does what the last prompt says, after `reaction_s`."""

    def __init__(self, reaction_s: float, deaf_to: str = "") -> None:
        self.now_us = UNIX_US
        self.prompted_us = UNIX_US
        self.prompt: Prompt = AWAY
        self.reaction_s, self.deaf_to = reaction_s, deaf_to
        self.words: list[str] = []

    def follow(self, prompt: Prompt) -> None:
        self.prompt, self.prompted_us = prompt, self.now_us
        self.words.append(prompt.words)

    def frames(self) -> Iterator[Frame]:
        while True:
            self.now_us += FRAME_US
            yield Frame(self.now_us, PIXEL, PIXEL)

    def see(self, frame: Frame) -> Observation | None:
        since_s = (frame.time_us - self.prompted_us) / 1e6 - self.reaction_s
        if self.prompt.name == "away":
            return None if since_s > 0.0 else at(100.0)
        if self.deaf_to and self.deaf_to in self.prompt.words:
            return at(30.0)
        if self.prompt.name in ("spot", "tap"):
            return at(900.0) if 0.0 < since_s < 0.4 else at(30.0)
        return at(1200.0 if self.prompt.force_g else 150.0) if since_s > 0.0 else at(30.0)


def session(finger: Finger, tmp_path: Path, tasks):
    kept: list[Frame] = []
    announcer = Announcer(finger.words.append, tmp_path / PAGE, finger.follow, sound=False)
    followed = follow_tasks(tasks, finger.frames(), finger.see, announcer, kept.append, TOUCH_RAW)
    announcer.close()
    return followed, kept


@pytest.mark.parametrize("reaction_s", [0.5, 7.0], ids=["quick", "slow"])
def test_it_is_paced_by_the_finger_and_records_only_what_counts(tmp_path, reaction_s) -> None:
    tasks = list(tasks_of(SURFACE, PlanOptions(brief=True)))
    finger = Finger(reaction_s)
    followed, kept = session(finger, tmp_path, tasks)
    assert followed.missed == []
    assert [line["step"] for line in followed.lines] == [task.step for task in tasks]
    assert followed.frames == len(kept)
    times_us = [frame.time_us for frame in kept]
    assert times_us[0] == 0
    assert (np.diff(times_us) > 0).all()
    assert len(kept) < 12 * 75, "the waiting is not recorded, however long it is"
    for line, after in zip(followed.lines, followed.lines[1:], strict=False):
        assert line["from_s"] < line["to_s"] <= after["from_s"]
        inside = [us for us in times_us if line["from_s"] <= us / 1e6 <= line["to_s"]]
        assert len(inside) >= 20, line
    spans = [
        [line["to_s"] - line["from_s"] for line in lines]
        for lines in (followed.lines, followed.live_lines)
    ]
    np.testing.assert_allclose(*spans, atol=1e-3)
    assert followed.live_lines[-1]["to_s"] > followed.lines[-1]["to_s"]
    assert not (tmp_path / PAGE).exists(), "the page goes with the session"


def test_a_touch_that_is_not_felt_is_in_the_script_and_the_session_goes_on(tmp_path) -> None:
    tasks = list(tasks_of(SURFACE, PlanOptions(brief=True)))[:4]
    finger = Finger(0.5, deaf_to="cross 1-4")
    followed, kept = session(finger, tmp_path, tasks)
    assert followed.missed == [tasks[1].prompt.words]
    assert len(followed.lines) == 4
    missed = followed.lines[1]
    assert 1.0 < missed["to_s"] - missed["from_s"] < 1.6
    assert any(missed["from_s"] < frame.time_us / 1e6 < missed["to_s"] for frame in kept)


def test_what_is_far_from_the_crosses_and_colour_are_left_out(profile: Profile) -> None:
    shape = (profile.camera.depth.height, profile.camera.depth.width)
    rng = np.random.default_rng(1)
    frame = Frame(
        0,
        np.full(shape, 500, np.uint16),
        rng.integers(2000, 2600, shape, np.uint16),
        b"\xff\xd8 colour",
    )
    cutter = Cutter(profile, frame)
    cut = cutter.cut(frame)
    assert cut.colour is None
    assert 0.1 < np.mean(cut.depth > 0) < 0.95
    inside = cut.ir > 0
    assert (cut.ir[inside] % 128 == 0).all(), "2300 / 16, and a power of two below"
    assert np.abs(frame.ir[inside].astype(int) - cut.ir[inside]).max() < 128
    assert np.mean(cut.depth > 0) < np.mean(near_surface(profile))


def test_the_page_shows_the_prompt_in_large_letters_and_loads_itself_again(tmp_path) -> None:
    page = page_of("Touch <cross> 1-1.", "3 of 52")
    assert "Touch &lt;cross&gt; 1-1." in page
    assert "http-equiv='refresh' content='1'" in page
    announcer = Announcer([].append, tmp_path / PAGE, sound=False)
    announcer.prompt(Prompt("tap", "Touch it."), "1 of 2")
    assert "Touch it." in (tmp_path / PAGE).read_text()
    announcer.tone("done")
    announcer.close()


def test_a_tone_is_a_wav_file_without_clicks(tmp_path) -> None:
    write_tone(tmp_path / "tone.wav", (660.0, 880.0))
    with wave.open(str(tmp_path / "tone.wav")) as file:
        sound = np.frombuffer(file.readframes(file.getnframes()), "<i2").astype(float)
    assert 5000 < np.abs(sound).max() < 32_000
    assert abs(sound[0]) < 50
    assert abs(sound[-1]) < 500


def test_what_is_missing_stops_it_before_a_folder_is_made(tmp_path, monkeypatch, capsys) -> None:
    monkeypatch.setattr("halo_service.app.doctor.found_cameras", list)
    command = ["first-light", str(tmp_path / "table"), "--profile", "desk"]
    assert main([*command, "--source", "femto-bolt"]) == 2
    said = capsys.readouterr().err
    assert "first-light: camera: no Femto Bolt is plugged in; plug it into a USB 3 port" in said
    assert not (tmp_path / "table").exists()
