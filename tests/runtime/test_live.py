"""The live loop, with a scripted camera: whatever it does, clients are told and nothing sticks."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Sequence

import numpy as np
import pytest

from halo_service.errors import UserError
from halo_service.geometry.camera import Camera, Lens
from halo_service.runtime.beside import TrackerBeside
from halo_service.runtime.live import LiveLoop
from halo_service.runtime.vitals import Vitals
from halo_service.sensing import SensingSettings, State, start
from halo_service.sources import EndOfSource, SourceLost
from halo_service.values import BadFrame, Frame, SourceKind, TouchFrame, Tracked

FRAME_US = 33_333
CAMERA = Camera("S", "NFOV_UNBINNED", 30, Lens(4, 4, 5, 5, 2, 2), None, np.eye(4))


class Scripted:
    """A source that does what its script says, one line a read; then it ends."""

    kind: SourceKind = "camera"
    camera = CAMERA

    def __init__(self, script: Sequence[Frame | BadFrame | Exception | None]) -> None:
        self.script = list(script)
        self.closed = False

    def read(self, timeout_s: float) -> Frame | BadFrame | None:
        if not self.script:
            raise EndOfSource
        line = self.script.pop(0)
        if isinstance(line, Exception):
            raise line
        if line is None:
            time.sleep(timeout_s)
        return line

    def close(self) -> None:
        self.closed = True


class Listener:
    """A publisher that keeps what it is told."""

    def __init__(self) -> None:
        self.frames: list[TouchFrame] = []
        self.scenes = 0
        self.vitals: list[Vitals] = []

    def frame(self, told: TouchFrame) -> None:
        self.frames.append(told)

    def scene(self, state: State) -> None:
        self.scenes += 1

    def health(self, vitals: Vitals) -> None:
        self.vitals.append(vitals)


class Blind:
    """A tracker that sees nothing."""

    def look(self, frame: Frame) -> Tracked:
        return Tracked(frame.time_us, ())

    def close(self) -> None:
        pass


def frame(n: int, depth_mm: int = 500) -> Frame:
    depth = np.full((4, 4), depth_mm, np.uint16)
    return Frame(n * FRAME_US, depth, depth)


def run(
    script: Sequence[Frame | BadFrame | Exception | None],
    reopen: Callable[[], Scripted] | None = None,
    make: Callable[[], Blind] = Blind,
) -> tuple[Listener, Scripted]:
    listener, source = Listener(), Scripted(script)
    tracker = TrackerBeside(make)

    def never() -> Scripted:
        raise UserError("no camera")

    loop = LiveLoop(source, reopen or never, tracker, start(None, SensingSettings()), listener)
    guard = threading.Timer(30.0, loop.stop)  # a loop that never ends must fail, not hang
    guard.start()
    try:
        loop.run()
    finally:
        guard.cancel()
        tracker.close()
    return listener, source


def test_every_frame_is_told_and_the_end_is_an_empty_frame() -> None:
    listener, source = run([frame(n) for n in range(5)])
    assert [told.time_us for told in listener.frames[:5]] == [n * FRAME_US for n in range(5)]
    assert len(listener.frames) == 6
    assert listener.frames[-1].pointers == ()
    assert listener.vitals[-1].camera == "ended"
    assert listener.scenes >= 1
    assert source.closed


@pytest.mark.parametrize(
    ("bad", "counted"),
    [
        (BadFrame(FRAME_US, "no depth"), 1),
        (frame(1, depth_mm=0), 1),
        (frame(-4), 1),
        (frame(300), 1),
    ],
    ids=["without depth", "all zero", "time back", "time ahead"],
)
def test_a_bad_frame_is_counted_and_told_as_an_empty_frame(
    bad: Frame | BadFrame, counted: int
) -> None:
    after = frame(round(bad.time_us / FRAME_US) + 1)
    listener, _ = run([frame(0), bad, after])
    assert len(listener.frames) == 4
    assert listener.vitals[-1].bad_frames == counted


def test_missing_frames_are_counted() -> None:
    listener, _ = run([frame(0), frame(1), frame(4)])
    assert listener.vitals[-1].drops == 2


def test_a_silent_camera_is_told_at_1_hz() -> None:
    listener, _ = run([frame(0), *[None] * 8, frame(61)])
    assert len(listener.frames) >= 4
    assert all(told.pointers == () for told in listener.frames)


def test_an_unplugged_camera_is_waited_for() -> None:
    back = Scripted([frame(0), frame(1)])
    tries = 0

    def reopen() -> Scripted:
        nonlocal tries
        tries += 1
        if tries < 2:
            raise UserError("no camera")
        return back

    listener, lost = run([frame(0), SourceLost("camera: it went away")], reopen)
    assert lost.closed
    assert back.closed
    assert tries == 2
    assert any(vitals.camera == "lost" for vitals in listener.vitals)
    assert listener.vitals[-1].camera == "ended"


def test_a_tracker_that_cannot_be_had_ends_the_service_with_its_sentence() -> None:
    def make() -> Blind:
        raise UserError("the hand model cannot be fetched")

    with pytest.raises(UserError, match="hand model"):
        run([frame(n) if n % 2 else None for n in range(100)], make=make)


def test_a_tracker_that_fails_once_is_started_anew() -> None:
    class Shaky(Blind):
        made = 0

        def __init__(self) -> None:
            Shaky.made += 1

        def look(self, frame: Frame) -> Tracked:
            if Shaky.made == 1:
                raise RuntimeError("a model of others")
            return super().look(frame)

    script: list[Frame | None] = [frame(0), *[None] * 6, frame(46), None, None]
    listener, _ = run(script, make=Shaky)
    assert Shaky.made == 2
    assert listener.vitals[-1].tracker == "searching"
