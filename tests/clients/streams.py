"""Streams for the tests of clients: written by hand, or sensed from the virtual camera (slow)."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest

from halo_protocol import Down, Pointer, TouchFrame, Up

LEFT, RIGHT = 1, 2
HOVER, TOUCH = 0, 1
EMPTY_S = 2.5
"""A virtual session starts with 3 s of empty table, which the tests do not need."""


def finger(
    id: int = 1,  # noqa: A002 - the wire's name
    *,
    hand: int = RIGHT,
    at: tuple[float, float] = (150.0, 100.0),
    hover_mm: float = 0.0,
    pressure: float | None = None,
    contacts: int = 1,
) -> Pointer:
    """A finger that touches if a pressure is given, else hovers."""
    state = HOVER if pressure is None else TOUCH
    u, v = at[0] / 300.0, at[1] / 200.0
    return Pointer(
        id, 0, hand, 1, state, u, v, *at, hover_mm, pressure or 0.0, 0.0, 0.0, 0.9, contacts, -1.0
    )


def down(
    id: int = 1,  # noqa: A002
    *,
    at: tuple[float, float] = (150.0, 100.0),
    strike_mm_s: float = 200.0,
    ago_ms: float = 12.0,
    contacts: int = 1,
) -> Down:
    return Down(id, 0, at[0] / 300.0, at[1] / 200.0, strike_mm_s, ago_ms, contacts)


def up(id: int = 1, *, at: tuple[float, float] = (150.0, 100.0), contacts: int = 1) -> Up:  # noqa: A002
    return Up(id, 0, at[0] / 300.0, at[1] / 200.0, 5.0, contacts)


def frame(number: int, pointers: Sequence[Pointer] = (), **events: Any) -> TouchFrame:
    """Frame `number` of a stream with 30 frames a second."""
    time_us = 1_000_000 + number * 33_333
    return TouchFrame("table", "desk", "s1", number, time_us, tuple(pointers), **events)


@pytest.fixture(scope="session")
def wire() -> Any:
    """Functions that write frames, pointers and events by hand."""

    class Wire:
        finger = staticmethod(finger)
        down = staticmethod(down)
        up = staticmethod(up)
        frame = staticmethod(frame)

    return Wire


@dataclass(frozen=True)
class Session:
    """A scenario of the virtual camera as the service senses it, with its ground truth."""

    stream: Path
    truth: list[dict[str, Any]]
    frames: list[Any]
    """The service's own frames, before they are encoded."""


@pytest.fixture(scope="session")
def sensed(tmp_path_factory: pytest.TempPathFactory) -> Callable[[str, float], Session]:
    """`sensed("sim:drumming?seed=3", 12.0)`; cached, so tests of one file share it."""
    sessions: dict[str, Session] = {}

    def make(name: str, seconds: float) -> Session:
        if name not in sessions:
            path = tmp_path_factory.mktemp("sensed") / "recording.jsonl"
            sessions[name] = sense(name, seconds, path)
        return sessions[name]

    return make


def sense(name: str, seconds: float, path: Path) -> Session:
    """Sense a scenario of the virtual camera, and write its stream to `path`."""
    from halo_service.app.hand_detector import HandDetector
    from halo_service.app.virtual_user.cache import cached_profile
    from halo_service.app.virtual_user.profile import virtual_profile
    from halo_service.outputs.jsonl import frame_line
    from halo_service.runtime.method import OURS
    from halo_service.runtime.replay import replay
    from halo_service.settings import Settings
    from halo_service.sources import EndOfSource
    from halo_service.virtual.offline import SimulatedRecording
    from halo_service.virtual.sim_url import parse_sim_url

    class RecordingSource:
        """A virtual recording as a source; collects its ground truth."""

        kind = "virtual"

        def __init__(self, recording: SimulatedRecording, truth: list[dict[str, Any]]) -> None:
            self.camera, self.surface = recording.camera, recording.surface
            self._lines: Iterator[Any] = iter(recording)
            self._truth = truth

        def read(self, timeout_s: float) -> Any:
            for frame, lines in self._lines:
                self._truth += lines
                if frame is not None:
                    return frame
            raise EndOfSource

        def close(self) -> None:
            """Nothing is open."""

    request, truth = parse_sim_url(name), []
    profile = cached_profile(request.room, Settings(), virtual_profile)
    recording = SimulatedRecording(request, seconds, colour=False, start_s=EMPTY_S)
    source = RecordingSource(recording, truth)
    detector = HandDetector(source.camera, profile, Settings().tracking, paced=True)
    try:
        state = OURS.start(profile, Settings().sensing)
        frames = list(replay(source, detector.detect, OURS, state))
    finally:
        detector.close()
    path.write_text("".join(frame_line(each, "sim", "s1", n) for n, each in enumerate(frames)))
    truth.append({"surface": source.surface})
    return Session(path, truth, frames)
