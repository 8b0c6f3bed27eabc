"""A studio whose tracker sees nobody, and a folder with one person's empty table in it."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from halo_service.evaluation.study.cache import Look, Studio
from halo_service.evaluation.study.plan import CALIBRATION, Person, Task
from halo_service.evaluation.study.recording import Kept, Line, keep_whole, save
from halo_service.geometry.camera import Camera
from halo_service.profile import Profile
from halo_service.values import Tracked
from halo_service.virtual.offline import Take
from halo_service.virtual.scenarios.calibration import BACKGROUND_S
from halo_service.virtual.sim_url import parse_sim_url

PERSON = Person(205, "paper")
SHORT = Task("short", "demo", 0.5, ends=False)
LONG = Task("long", "demo", 60.0, ends=False)
STATES = ("hover", "subtle", "touch", "pressure")
SCRIPT: tuple[Line, ...] = (
    {"step": "background", "from_s": 0.0, "to_s": BACKGROUND_S},
    *({"step": name, "from_s": 3.0 + k, "to_s": 3.5 + k} for k, name in enumerate(STATES)),
)
"""The states of which nobody has come to hold any."""


@contextmanager
def blind(camera: Camera, profile: Profile | None, hands: int) -> Iterator[Look]:
    """A hand tracker that sees nobody: who draws takes needs no more."""
    yield lambda frame: Tracked(frame.time_us, ())


def studio_in(folder: Path) -> Studio:
    """Keep a person's empty table there, and nothing else."""
    studio = Studio(folder, blind, "nobody")
    empty = Take(
        parse_sim_url(f"sim:idle?seed={PERSON.seed}&material=paper"), BACKGROUND_S, colour=False
    )
    captures = [keep_whole(frame, Tracked(0, ())) for frame, _ in empty if frame is not None]
    made = studio.made(PERSON, CALIBRATION)
    save(studio.path(PERSON, CALIBRATION), Kept(tuple(captures), (), SCRIPT), made)
    return studio
