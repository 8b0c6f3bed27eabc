"""The live loop with a scripted camera: clients always receive frames, and no pointer stays."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import ClassVar

import numpy as np
import pytest

from halo_service.errors import UserError
from halo_service.geometry.camera import Camera, Lens
from halo_service.profile import Profile
from halo_service.runtime.health import Health, SlowWatch
from halo_service.runtime.live import LiveLoop
from halo_service.runtime.load import LOOK_US
from halo_service.runtime.method import OURS, Method
from halo_service.runtime.tracker_thread import TrackerThread
from halo_service.sensing import SensingSettings, State, start, step
from halo_service.sources import EndOfSource, Source, SourceLost
from halo_service.values import BadFrame, Frame, SourceKind, Touch, TouchFrame, Tracked

pytestmark = pytest.mark.slow

FRAME_US = 33_333
LATE_S = 0.3
"""The delay that a busy machine may add."""
CAMERA = Camera("S", "NFOV_UNBINNED", 30, Lens(4, 4, 5, 5, 2, 2), None, np.eye(4))


class Scripted:
    """A source that follows its script, one line a read; then it ends."""

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
    """A publisher that keeps what it gets."""

    def __init__(self) -> None:
        self.sent: list[tuple[float, TouchFrame]] = []
        self.scenes = 0
        self.healths: list[Health] = []

    @property
    def frames(self) -> list[TouchFrame]:
        return [each for _, each in self.sent]

    def frame(self, touch_frame: TouchFrame) -> None:
        self.sent.append((time.monotonic(), touch_frame))

    def scene(self, state: State) -> None:
        self.scenes += 1

    def health(self, health: Health) -> None:
        self.healths.append(health)


class Blind:
    """A tracker that sees nothing."""

    looks = 0

    def detect(self, frame: Frame) -> Tracked:
        return Tracked(frame.time_us, ())

    def close(self) -> None:
        pass


def frame(n: int, depth_mm: int = 500) -> Frame:
    depth = np.full((4, 4), depth_mm, np.uint16)
    return Frame(n * FRAME_US, depth, depth)


def run(
    script: Sequence[Frame | BadFrame | Exception | None],
    reopen: Callable[[], Scripted] | None = None,
    make: Callable[[], Blind] | None = Blind,
    state: State | None = None,
    method: Method[State] = OURS,
    listener: Listener | None = None,
    control: Callable[[State, Source | None], State] = lambda state, source: state,
    watch: Callable[[Frame], None] = lambda frame: None,
    paused: threading.Event | None = None,
) -> tuple[Listener, Scripted]:
    listener, source = listener or Listener(), Scripted(script)
    tracker = TrackerThread(make) if make else None
    state = state or start(None, SensingSettings())

    def never() -> Scripted:
        raise UserError("no camera")

    loop = LiveLoop(
        source, reopen or never, tracker, state, listener, control, watch, method, paused
    )
    guard = threading.Timer(30.0, loop.stop)  # a loop that never ends must fail, not hang
    guard.start()
    try:
        loop.run()
    finally:
        guard.cancel()
        if tracker is not None:
            tracker.close()
    return listener, source


def test_every_frame_is_sent_and_the_end_is_an_empty_frame() -> None:
    listener, source = run([frame(n) for n in range(5)])
    assert [each.time_us for each in listener.frames[:5]] == [n * FRAME_US for n in range(5)]
    assert len(listener.frames) == 6
    assert listener.frames[-1].pointers == ()
    assert listener.healths[-1].camera == "ended"
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
def test_a_bad_frame_is_counted_and_sent_as_an_empty_frame(
    bad: Frame | BadFrame, counted: int
) -> None:
    after = frame(round(bad.time_us / FRAME_US) + 1)
    listener, _ = run([frame(0), bad, after])
    assert len(listener.frames) == 4
    assert listener.healths[-1].bad_frames == counted


def test_missing_frames_are_counted() -> None:
    listener, _ = run([frame(0), frame(1), frame(4)])
    assert listener.healths[-1].drops == 2


def test_a_silent_camera_gives_frames_at_1_hz() -> None:
    listener, _ = run([frame(0), *[None] * 12, frame(92)])
    gaps_s = np.diff([sent_s for sent_s, _ in listener.sent])
    assert len(gaps_s) >= 5
    assert max(gaps_s) < 1.0 + LATE_S
    assert all(each.pointers == () for each in listener.frames)


def test_an_unplugged_camera_is_opened_again() -> None:
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
    assert any(health.camera == "lost" for health in listener.healths)
    assert listener.healths[-1].camera == "ended"


def test_a_tracker_that_cannot_be_loaded_ends_the_service_with_its_sentence() -> None:
    def make() -> Blind:
        raise UserError("the hand model cannot be fetched")

    with pytest.raises(UserError, match="hand model"):
        run([frame(n) if n % 2 else None for n in range(100)], make=make)


def test_a_tracker_that_fails_once_is_started_again() -> None:
    class Shaky(Blind):
        made = 0

        def __init__(self) -> None:
            Shaky.made += 1

        looks = 0

        def detect(self, frame: Frame) -> Tracked:
            if Shaky.made == 1:
                raise RuntimeError("a broken model")
            return super().detect(frame)

    script: list[Frame | None] = [frame(0), *[None] * 6, frame(46), None, None]
    listener, _ = run(script, make=Shaky)
    assert Shaky.made == 2
    assert listener.healths[-1].tracker == "searching"


def touching(profile: Profile, draw: Callable[..., Frame], see: Callable[..., Tracked]) -> State:
    """A state in which a finger touches; its last frame was number 5."""
    state = start(profile, SensingSettings())
    for n, signal in enumerate([0.0, 0.0, 2200.0, 2200.0, 2200.0, 2200.0]):
        at_us = n * FRAME_US
        shown, state = step(state, draw(signal=signal, time_us=at_us), see(time_us=at_us))
    assert [pointer.state for pointer in shown.pointers] == [Touch.TOUCH]
    return state


@pytest.mark.parametrize(
    "bad",
    [
        [BadFrame(7 * FRAME_US, "no depth")],
        [frame(7, depth_mm=0)],
        [frame(3)],
        [frame(300)],
        [SourceLost("camera: it went away")],
        [None, None, None, None],
        [],
    ],
    ids=["without depth", "all zero", "time back", "time ahead", "unplugged", "silent", "ended"],
)
def test_whatever_happens_a_touch_is_released_with_its_up(
    bad: list[Frame | BadFrame | Exception | None],
    profile: Profile,
    draw: Callable[..., Frame],
    see: Callable[..., Tracked],
) -> None:
    state = touching(profile, draw, see)
    rests = draw(signal=2200.0, time_us=6 * FRAME_US)
    listener, _ = run([rests, *bad], lambda: Scripted([]), state=state)
    assert [pointer.state for pointer in listener.frames[0].pointers] == [Touch.TOUCH]
    after = [each for each in listener.frames if each.pointers == ()]
    assert [event.kind for each in after for event in each.events] == ["up"]
    assert listener.frames[-1].pointers == ()


def test_time_never_goes_back_over_bad_frames_and_silence() -> None:
    script = [frame(0), frame(1, depth_mm=0), frame(2), None, None, None, frame(27), frame(28)]
    listener, _ = run(script)
    times = [each.time_us for each in listener.frames]
    assert times == sorted(times)


def test_frames_never_outrun_the_seed_of_the_frame_counter() -> None:
    listener, _ = run([frame(n) for n in range(40)])
    sent_s = [at_s for at_s, _ in listener.sent]
    assert min(np.diff(sent_s)) > 0.0099


def test_while_no_camera_comes_back_frames_are_sent_without_a_gap() -> None:
    tries = 0

    def reopen() -> Scripted:
        nonlocal tries
        tries += 1
        if tries < 4:
            raise UserError("no camera")
        return Scripted([])

    listener, _ = run([frame(0), SourceLost("camera: it went away")], reopen)
    gaps_s = np.diff([sent_s for sent_s, _ in listener.sent])
    assert max(gaps_s) < 1.0 + LATE_S


def test_without_a_tracker_health_reports_it_off() -> None:
    listener, _ = run([frame(n) for n in range(5)], make=None)
    assert listener.healths[-1].tracker == "off"


def failing(*frames: int) -> Method[State]:
    """Our method with an error in it, at these frames' times."""

    def broken(state: State, frame: Frame, tracked: Tracked | None) -> tuple[TouchFrame, State]:
        if frame.time_us in [n * FRAME_US for n in frames]:
            raise IndexError("index 640 is out of bounds")
        return step(state, frame, tracked)

    return replace(OURS, step=broken)


def tracebacks(caplog: pytest.LogCaptureFixture) -> list[str]:
    return [each.getMessage() for each in caplog.records if each.exc_info]


@pytest.mark.parametrize(
    ("at", "good"),
    [((2,), [0, 1, 3, 4, 5]), ((0, 1, 4), [2, 3, 5]), (tuple(range(6)), [])],
    ids=["one frame", "some frames", "every frame"],
)
def test_an_error_in_a_frame_costs_that_frame_alone(
    at: tuple[int, ...], good: list[int], caplog: pytest.LogCaptureFixture
) -> None:
    listener, source = run([frame(n) for n in range(6)], method=failing(*at))
    assert [each.time_us for each in listener.frames[:-1]] == [n * FRAME_US for n in range(6)]
    assert listener.healths[-1].bad_frames == len(at)
    assert source.closed
    assert tracebacks(caplog) == [
        "sensing failed: IndexError: index 640 is out of bounds; this kind of error is logged once"
    ]
    assert sum("good again" in each.getMessage() for each in caplog.records) == (
        {(2,): 1, (0, 1, 4): 2}.get(at, 0)
    )


def test_an_error_in_a_frame_releases_a_touch_and_the_next_frame_is_sensed(
    profile: Profile, draw: Callable[..., Frame], see: Callable[..., Tracked]
) -> None:
    class Seeing(Blind):
        looks = 0

        def detect(self, frame: Frame) -> Tracked:
            return see(time_us=frame.time_us)

    rests = [draw(signal=2200.0, time_us=n * FRAME_US) for n in (6, 7, 8, 9)]
    script: list[Frame | None] = [rests[0], rests[1], None, rests[2], rests[3]]
    listener, _ = run(script, make=Seeing, state=touching(profile, draw, see), method=failing(7))
    shown = {each.time_us // FRAME_US: each for each in reversed(listener.frames)}
    assert [pointer.state for pointer in shown[6].pointers] == [Touch.TOUCH]
    assert shown[7].pointers == ()
    assert [event.kind for event in shown[7].events] == ["up"]
    assert [pointer.state for pointer in shown[9].pointers] == [Touch.HOVER]
    assert shown[9].pointers[0].id > shown[6].pointers[0].id


def test_a_pause_releases_a_touch_and_reports_the_tracker_off(
    profile: Profile, draw: Callable[..., Frame], see: Callable[..., Tracked]
) -> None:
    paused = threading.Event()
    paused.set()
    rests: list[Frame | None] = [draw(signal=2200.0, time_us=n * FRAME_US) for n in (6, 7)]
    listener, _ = run(rests, state=touching(profile, draw, see), paused=paused)
    assert [each.time_us for each in listener.frames[:2]] == [6 * FRAME_US, 7 * FRAME_US]
    assert all(each.pointers == () for each in listener.frames)
    assert [event.kind for each in listener.frames for event in each.events] == ["up"]
    assert {each.tracker for each in listener.healths} == {"off"}


def test_a_tracker_is_made_again_when_what_it_is_made_from_changed() -> None:
    made = threading.Semaphore(0)

    def make() -> Blind:
        made.release()
        return Blind()

    tracker = TrackerThread(make)
    try:
        assert made.acquire(timeout=10.0)
        tracker.reload()
        assert made.acquire(timeout=10.0)
        assert not made.acquire(timeout=0.5)
    finally:
        tracker.close()


def test_a_tracker_that_leaks_is_made_again_and_health_shows_the_memory(
    monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    made: list[Blind] = []

    def make() -> Blind:
        made.append(Blind())
        return made[-1]

    used = iter([300, 300, 900, *[310] * 20])
    monkeypatch.setattr("halo_service.runtime.health.memory_mb", lambda: next(used))
    monkeypatch.setattr("halo_service.runtime.memory.SETTLE_S", 0.0)
    monkeypatch.setattr("halo_service.runtime.live.HEALTH_S", 0.0)
    listener, _ = run([*map(frame, range(10)), None, None], make=make)
    assert len(made) == 2
    assert "memory: it grew to 900 MB; the hand model is loaded again" in caplog.text
    assert [health.memory_mb for health in listener.healths[:4]] == [300, 300, 900, 310]


def test_frames_of_one_source_that_all_fail_do_not_harm_the_next_source() -> None:
    script = [*(frame(n) for n in range(3)), SourceLost("camera: it went away")]
    second = Scripted([frame(n) for n in range(10, 13)])
    listener, _ = run(script, lambda: second, method=failing(0, 1, 2))
    assert listener.healths[-1].bad_frames == 3
    assert listener.healths[-1].camera == "ended"
    assert second.closed


def test_a_source_with_an_unexpected_error_goes_on(caplog: pytest.LogCaptureFixture) -> None:
    script = [frame(0), ValueError("a broken packet"), ValueError("a broken packet"), frame(1)]
    listener, _ = run(script)
    assert listener.healths[-1].bad_frames == 2
    assert FRAME_US in [each.time_us for each in listener.frames]
    assert len(tracebacks(caplog)) == 1


def test_a_source_that_only_fails_is_opened_again(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("halo_service.runtime.live.START_S", 0.2)
    second = Scripted([frame(0)])
    listener, first = run([ValueError("dead")] * 200, lambda: second)
    assert first.closed
    assert first.script
    assert second.closed
    assert listener.healths[-1].camera == "ended"


def test_a_camera_that_starts_slowly_is_not_opened_again_and_again(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr("halo_service.runtime.live.SILENCE_S", 0.1)
    listener, source = run([None, None, None, frame(0), frame(1)])
    assert not source.script  # the same source was read to its end
    assert listener.healths[-1].camera == "ended"
    assert not any(health.camera == "lost" for health in listener.healths)


def test_a_camera_that_went_silent_may_start_as_slowly_again(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr("halo_service.runtime.live.SILENCE_S", 0.1)
    opened: list[Scripted] = []

    def reopen() -> Scripted:
        opened.append(Scripted([None, None, frame(90), frame(91)]))
        return opened[-1]

    run([frame(0), None, None], reopen)
    assert len(opened) == 1


def test_a_service_that_is_too_slow_says_so_once_and_says_when_it_is_over() -> None:
    watch = SlowWatch()
    rates = [29.8] * 5 + [14.0, 0.0, 14.0, 14.0, 14.0, 15.0, 13.0, 27.0, 29.0, 29.5, 29.9, 30.0]
    said = [watch.see(fps, 30.0) for fps in rates]
    assert [n for n, each in enumerate(said) if each] == [9, 15]
    assert "only 14 of 30 frames a second" in said[9]
    assert "30 frames a second again" in said[15]


@pytest.mark.parametrize("part", ["frame", "scene", "health", "control", "profile"])
def test_an_error_around_the_sensing_does_not_end_the_service(
    part: str, caplog: pytest.LogCaptureFixture
) -> None:
    def fail(*_: object) -> State:
        raise RuntimeError(part)

    broken = Listener()
    if part in ("frame", "scene", "health"):
        setattr(broken, part, fail)
    script = [frame(n) for n in range(4)]
    listener, source = run(
        script,
        listener=broken,
        control=fail if part == "control" else lambda state, source: state,
        watch=fail if part == "profile" else lambda frame: None,
    )
    assert source.closed
    assert not source.script
    assert len(listener.frames) == (0 if part == "frame" else 5)
    assert 1 <= len(tracebacks(caplog)) <= 2  # a frame that is not sent: in sensing and in release


def test_an_unexpected_error_of_a_tracker_is_logged_once_and_its_hands_are_forgotten(
    caplog: pytest.LogCaptureFixture, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("halo_service.runtime.tracker_thread.AGAIN_S", 0.05)

    class Worse(Blind):
        looks = 0

        def detect(self, frame: Frame) -> Tracked:
            Worse.looks += 1
            if Worse.looks > 1:
                raise RuntimeError("the model is broken")
            return super().detect(frame)

    script: list[Frame | None] = []
    for n in range(7):
        script += [frame(n), None]
    listener, _ = run(script, make=Worse)
    assert len(tracebacks(caplog)) == 1
    assert Worse.looks >= 3
    assert listener.healths[-1].bad_frames == 0
    assert listener.healths[-1].tracker_ms == -1.0


def test_a_model_that_goes_missing_later_does_not_end_the_service(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr("halo_service.runtime.tracker_thread.AGAIN_S", 0.05)
    made: list[Blind] = []

    class Once(Blind):
        looks = 0

        def detect(self, frame: Frame) -> Tracked:
            raise RuntimeError("the model is broken")

    def make() -> Blind:
        if made:
            raise UserError("the hand model cannot be fetched")
        made.append(Once())
        return made[0]

    listener, source = run([frame(0), None, frame(1), None, frame(2)], make=make)
    assert not source.script
    assert FRAME_US * 2 in [each.time_us for each in listener.frames]


def test_under_load_the_hand_tracker_gets_fewer_frames_and_every_packet_is_sent() -> None:
    class Counting(Blind):
        seen: ClassVar[list[int]] = []

        looks = 0

        def detect(self, each: Frame) -> Tracked:
            self.seen.append(each.time_us)
            return super().detect(each)

    def slow(state: State, each: Frame, tracked: Tracked | None) -> tuple[TouchFrame, State]:
        time.sleep(0.8 * FRAME_US / 1e6)
        return OURS.step(state, each, tracked)

    count = 40
    listener, _ = run(
        [frame(n) for n in range(count)], make=Counting, method=replace(OURS, step=slow)
    )
    assert len(listener.frames) == count + 1
    gaps = np.diff(Counting.seen)
    assert len(gaps) and gaps[-3:].min() >= LOOK_US[1]
    assert len(Counting.seen) < count / 2
