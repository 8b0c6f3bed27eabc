"""One user's calibration without a hand, and a hand tracker that finds none."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from itertools import islice
from pathlib import Path

from halo_service.evaluation.study.cache import RecordingCache
from halo_service.evaluation.study.plan import CALIBRATION, Task, User
from halo_service.evaluation.study.recording import Line, StoredRecording, save, store_whole
from halo_service.evaluation.study.simulate import Tracker
from halo_service.geometry.camera import Camera
from halo_service.profile import Profile
from halo_service.values import Tracked
from halo_service.virtual.offline import SimulatedRecording
from halo_service.virtual.scenarios.calibration import background_s
from halo_service.virtual.sim_url import parse_sim_url

USER = User(205, "paper")
TABLE = parse_sim_url(f"sim:idle?seed={USER.seed}&material=paper")
EMPTY_S = background_s(TABLE.room)
SHORT = Task("short", "demo", 0.2, ends=False)
LONG = Task("long", "demo", 60.0, ends=False)
ENOUGH = 50
"""Frames of the empty table: the calibration needs 45."""
STATES = ("hover", "subtle", "touch", "pressure")
SCRIPT: tuple[Line, ...] = (
    {"step": "background", "from_s": 0.0, "to_s": EMPTY_S},
    *({"step": name, "from_s": 3.0 + k, "to_s": 3.5 + k} for k, name in enumerate(STATES)),
)
"""No state is held."""


@contextmanager
def blind(camera: Camera, profile: Profile | None, hands: int) -> Iterator[Tracker]:
    """A hand tracker that finds no hand: simulating needs no more."""
    yield lambda frame: Tracked(frame.time_us, ())


def store_empty_table(folder: Path) -> None:
    """Store the user's calibration with the empty table alone."""
    empty = SimulatedRecording(TABLE, EMPTY_S, colour=False)
    first = islice((frame for frame, _ in empty if frame is not None), ENOUGH)
    frames = [store_whole(frame, Tracked(0, ())) for frame in first]
    cache = cache_in(folder)
    recording = StoredRecording(tuple(frames), (), SCRIPT)
    save(cache.path(USER, CALIBRATION), recording, cache.key(USER, CALIBRATION))


def cache_in(folder: Path) -> RecordingCache:
    """Return a cache with a tracker that finds no hand."""
    return RecordingCache(folder, blind, "blind")
