"""`halo bench`: the latency of our pipeline and of the paper's, on the same frames."""

from __future__ import annotations

import json
import math
import platform
from collections.abc import Callable, Iterator
from contextlib import ExitStack, closing
from dataclasses import asdict, dataclass, replace
from functools import partial

import halo_protocol as wire
from halo_calibration.base_model import choose_base
from halo_calibration.solvers.correction import Reference, solve_correction
from halo_calibration.solvers.touch import corrected
from halo_service.app.benchmarking.table import lines, tables
from halo_service.app.files import written
from halo_service.app.hand_detector import HandDetector, model_for
from halo_service.app.progress import progress
from halo_service.app.service.publisher import Publisher
from halo_service.app.tables import print_tables
from halo_service.app.virtual_user.profile import virtual_profile
from halo_service.errors import UserError
from halo_service.evaluation.latency.blocks import run
from halo_service.evaluation.latency.figures import Case, case_of, goals
from halo_service.evaluation.latency.listener import Listener
from halo_service.evaluation.latency.raw_frames import to_raw
from halo_service.evaluation.latency.regressor import Regressor, regressor_for
from halo_service.evaluation.latency.sequential import Sequential
from halo_service.evaluation.latency.simulate import LatencyRecording, simulate
from halo_service.evaluation.latency.stopwatch import Stopwatch, TimedCarrier
from halo_service.files import from_home
from halo_service.hand_tracking.hands import HandTracker
from halo_service.outputs.destination import Destination
from halo_service.outputs.frame_encoder import FrameEncoder
from halo_service.outputs.osc import OscOutput
from halo_service.profile import Profile
from halo_service.profile.store import load, profile_path, require_fit, require_touch
from halo_service.runtime.tracker_thread import TrackerThread
from halo_service.sensing import State, start
from halo_service.settings import Settings
from halo_service.sources import EndOfSource
from halo_service.sources.recording import Recording
from halo_service.values import Frame
from halo_service.virtual.sim_url import SimRequest, parse_sim_url

CASES = {1: "sim:pointing?seed=1", 2: "sim:drumming?seed=1"}
"""The source for a number of hands, unless the user names one."""
ROUNDS = 2
"""Ours first, then ours last."""
LONGEST_S = 60.0
"""Frames are held in memory: 50 MB a second."""
NODE, SESSION = "bench", "s0"


@dataclass(frozen=True, slots=True)
class BenchRequest:
    """What the command line asks for."""

    hands: int | None
    """None: a recording with one hand, then one with two."""
    seconds: float
    source: str | None
    profile: str
    json: str | None


def bench(request: BenchRequest, settings: Settings) -> None:
    """Measure and print; write the JSON at the end. Raises `UserError`."""
    if not (math.isfinite(request.seconds) and 1.0 <= request.seconds <= LONGEST_S):
        raise UserError(
            f"bench: --seconds must be from 1 to {LONGEST_S:g}: frames are held in memory"
        )
    cases_of = (request.hands,) if request.hands else (1, 2)
    if request.source is not None:
        cases_of = (request.hands or settings.tracking.max_hands,)
    cases: list[Case] = []
    for hands in cases_of:
        source = request.source or CASES[hands]
        tracking = replace(settings.tracking, max_hands=hands)
        case = _case(source, hands, request, replace(settings, tracking=tracking))
        cases.append(case)
        print_tables(*tables(case), plain="\n".join(lines(case)))
    if request.json is not None:
        with written(request.json) as file:
            file.write(json.dumps(_report(cases), indent=1) + "\n")


class Service:
    """The parts of the service and of the paper's pipeline, as `halo serve` would connect them."""

    def __init__(
        self,
        recording: LatencyRecording,
        profile: Profile,
        regressor: Regressor,
        settings: Settings,
    ) -> None:
        self._recording = recording
        self._profile = profile
        self._regressor = regressor
        self._settings = settings

    def tracker(self) -> TrackerThread:
        """Start the hand tracker in its thread."""
        camera, tracking = self._recording.camera, self._settings.tracking
        return TrackerThread(partial(HandDetector, camera, self._profile, tracking, paced=True))

    def state(self) -> State:
        """Return the state of the sensing before the first frame."""
        return start(self._profile, self._settings.sensing)

    def publisher(self, watch: Stopwatch, port: int) -> tuple[Publisher, Callable[[], None]]:
        """Return a publisher to a port of this machine, and a function that closes it."""
        carrier = TimedCarrier(OscOutput([Destination("127.0.0.1", port)]), watch)
        name, recording = self._profile.surface.name, self._recording
        frames = FrameEncoder(NODE, SESSION, 0)
        return Publisher(frames, [carrier], recording.kind, recording.camera, name), carrier.close

    def sequential(self, watch: Stopwatch) -> tuple[Sequential, Callable[[], None]]:
        """Return the paper's pipeline with its own tracker, and a function that closes it."""
        profile, settings = self._profile, self._settings
        finder = HandTracker(model_for(settings.tracking), settings.tracking.max_hands)
        assert profile.touch is not None  # `_profile_for` checked it
        sequential = Sequential(
            profile, profile.touch, settings.sensing, finder, self._regressor, watch
        )
        return sequential, finder.close


def _case(source: str, hands: int, request: BenchRequest, settings: Settings) -> Case:
    kind, _, rest = source.partition(":")
    if kind == "sim":
        simulated = parse_sim_url(source)
        profile = _profile_for(request.profile) or _measured(simulated, settings)
        frames = round(request.seconds * simulated.room.camera().fps)
        with progress(f"rendering {source}", frames) as bar:
            recording = simulate(source, simulated, request.seconds, bar.advance)
    elif kind == "recording" and rest:
        given = _profile_for(request.profile)
        if given is None:
            raise UserError("bench: a recording needs the profile of its place: --profile P")
        profile, recording = given, _read(source, rest, request.seconds)
    else:
        raise UserError(
            f"bench: cannot use source '{source}'; choose from: sim[:SCENARIO], recording:FILE "
            f"('halo record' makes a recording of a camera)"
        )
    require_fit(profile, recording.camera)
    regressor = regressor_for(profile, choose_base("auto", recording.camera.serial))
    if regressor is None:
        raise UserError(
            f"bench: the profile '{profile.name}' has no sweep, which the paper's pipeline needs: "
            f"run 'halo calibrate sweep --profile {profile.name}'"
        )
    with ExitStack() as stack:
        listener = stack.enter_context(Listener())
        bar = stack.enter_context(progress(f"measuring {source}", 2 * ROUNDS))
        blocks = []
        for block in run(
            recording, Service(recording, profile, regressor, settings), listener, ROUNDS
        ):
            blocks.append(block)
            bar.advance()
    return case_of(recording, hands, blocks, profile.surface)


def _profile_for(name: str) -> Profile | None:
    if not name:
        return None
    profile = load(profile_path(name))
    require_touch(profile)
    return profile


def _measured(request: SimRequest, settings: Settings) -> Profile:
    """Calibrate on the virtual table, with the base model as correction: nothing is left out."""
    profile = virtual_profile(request.room, settings)
    assert profile.touch is not None  # `virtual_profile` measured it
    held = profile.touch.touch
    at = Reference(held.x_mm, held.y_mm, held.pitch_deg, held.yaw_deg)
    base = choose_base("auto", profile.camera.serial)
    correction = solve_correction(profile.surface, base, None, at)
    return replace(profile, correction=correction, touch=corrected(profile.touch, correction))


def _read(source: str, path: str, seconds: float) -> LatencyRecording:
    with closing(Recording(from_home(path), realtime=False, loop=False)) as recording:
        captures = tuple(to_raw(frame) for frame in _first(recording, seconds))
        return LatencyRecording(source, recording.kind, recording.camera, captures, None)


def _first(recording: Recording, seconds: float) -> Iterator[Frame]:
    start_us: int | None = None
    while True:
        try:
            capture = recording.read(1.0)
        except EndOfSource:
            return
        if not isinstance(capture, Frame):
            continue
        start_us = capture.time_us if start_us is None else start_us
        if capture.time_us - start_us >= 1e6 * seconds:
            return
        yield capture


def _report(cases: list[Case]) -> dict[str, object]:
    machine = {"system": platform.platform(), "python": platform.python_version()}
    return {
        "halo_bench": 1,
        "protocol": wire.VERSION,
        "machine": machine,
        "cases": [
            {**asdict(case), "ratio": case.ratio, "goals": [asdict(g) for g in goals(case)]}
            for case in cases
        ],
    }
