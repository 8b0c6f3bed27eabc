"""HaloTouch to the letter: what only this rival does."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from halo_calibration.base_model import VIRTUAL, pilot_path, read_base, write_base
from halo_service.evaluation.methods.paper.detector import Detector, detect
from halo_service.evaluation.methods.paper.method import PAPER
from halo_service.profile import Profile
from halo_service.sensing import SensingSettings
from halo_service.values import Frame, Touch, Tracked

FRAME_US = 33_333
ON_THE_TIP = (0.0, -6.0)
Draw = Callable[..., Frame]
See = Callable[..., Tracked]


def run(levels: list[float], speed_mm_s: float = 0.0) -> list[bool]:
    """Whether each frame of a level's course touches."""
    detector: Detector | None = None
    touching = []
    for n, level in enumerate(levels):
        detector = detect(detector, level, speed_mm_s, n * FRAME_US)
        touching.append(detector.touching)
    return touching


COURSES = {
    "a touch begins with its rise and ends when two frames agree": (
        [0, 0, 1, 1, 1, 0, 0, 0],
        [False, False, True, True, True, True, False, False],
    ),
    "a rise of one frame is a touch": (
        [0, 0, 1, 0, 0, 0],
        [False, False, True, True, False, False],
    ),
    "a dip of one frame ends none": (
        [0, 1, 1, 1, 0, 1, 1],
        [False, True, True, True, True, True, True],
    ),
    "what is high in its first frame has not risen": ([1, 1, 1, 1], [False] * 4),
    "a slow rise is followed by the baseline": ([0.02 * n for n in range(50)], [False] * 50),
}


@pytest.mark.parametrize("name", COURSES)
def test_detector(name: str) -> None:
    levels, touching = COURSES[name]
    assert run([float(level) for level in levels]) == touching


def test_a_finger_that_moves_fast_cannot_come_down() -> None:
    assert run([0.0, 0.0, 1.0, 1.0, 1.0], speed_mm_s=1000.0) == [False] * 5


def test_a_frame_waits_for_its_own_hands(profile: Profile, draw: Draw, see: See) -> None:
    state = PAPER.start(profile, SensingSettings())
    frames = [draw((300.0 + 5.0 * n, 288.0), 0.0, 0.0, n * FRAME_US) for n in range(4)]
    for n, frame in enumerate(frames):
        seen = see((300.0 + 5.0 * (n - 2), 288.0), (n - 2) * FRAME_US) if n >= 2 else None
        published, state = PAPER.step(state, frame, seen)
        assert len(published.pointers) == (n >= 2)
    (pointer,) = published.pointers
    assert pointer.diagnostics.tip_px[0] == 305.0  # the second frame's, two frames ago


def test_a_lost_hand_releases_its_pointer(profile: Profile, draw: Draw, see: See) -> None:
    """The drawn states: 1500 mm px is subtle, 2000 touch; 2880 is a dent of 12 mm."""
    state = PAPER.start(profile, SensingSettings())
    published = []
    for n in range(20):
        signal = 0.0 if n < 4 else 2880.0
        seen = see(time_us=n * FRAME_US, off=ON_THE_TIP)
        lost = Tracked(n * FRAME_US, ())
        frame = draw(signal=signal, time_us=n * FRAME_US)
        result, state = PAPER.step(state, frame, seen if n < 10 else lost)
        published.append(result)
    events = [(n, event.kind) for n, frame in enumerate(published) for event in frame.events]
    assert events == [(4, "down"), (17, "up")]
    assert [frame.pointers[0].state for frame in published[4:17]] == [Touch.TOUCH] * 13


def test_it_learns_the_states_of_its_own_signal(profile: Profile, draw: Draw, see: See) -> None:
    dents = {"hover": 9, "subtle": 10, "touch": 12, "pressure": 16}
    script = [{"step": state, "from_s": n, "to_s": n + 0.9} for n, state in enumerate(dents)]
    seen = []
    for n in range(30 * len(dents)):
        signal = 240.0 * list(dents.values())[n // 30]
        time_us = n * FRAME_US
        frame = draw(signal=signal, time_us=time_us)
        seen.append((frame, see(time_us=time_us, off=ON_THE_TIP)))
    assert PAPER.learn is not None
    learnt = PAPER.learn(profile, SensingSettings(), seen, script)
    assert learnt.touch is not None
    states = [getattr(learnt.touch, state).signal for state in dents]
    assert np.allclose(states, [240.0 * dent for dent in dents.values()])


def test_its_correction_uses_the_same_base_model_as_ours(
    profile: Profile, draw: Draw, see: See, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The evaluation ignores a camera's own base model."""
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path))
    serial = profile.camera.serial
    mine = replace(read_base(VIRTUAL), name="another", camera_serial=serial)
    write_base(mine, pilot_path(serial))
    signals = [240.0 * dent for dent in (9, 10, 12, 16)]
    held = [((320.0, 288.0), signal) for signal in signals for _ in range(30)]
    swept = [
        ((194.5 + 50.0 * column, 212.5 + 50.0 * row), signals[2])
        for row in range(4)
        for column in range(6)
        for _ in range(3)
    ]
    seen = [
        (draw(tip, signal, 0.0, n * FRAME_US), see(tip, n * FRAME_US, ON_THE_TIP))
        for n, (tip, signal) in enumerate(held + swept)
    ]
    steps = ("hover", "subtle", "touch", "pressure", "sweep")
    script = [{"step": step, "from_s": n, "to_s": n + 0.9} for n, step in enumerate(steps)]
    script[-1]["to_s"] = 6.5
    assert PAPER.learn is not None
    learnt = PAPER.learn(profile, SensingSettings(), seen, script)
    assert learnt.correction is not None
    assert learnt.correction.base == "virtual"
