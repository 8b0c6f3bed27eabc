"""Which user does which task: the paper's study as a table.

Rule: names and numbers only; the study's own (5.1, 5.2) unless a line says why not.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from urllib.parse import quote

from halo_service.errors import UserError
from halo_service.virtual.materials import STUDIED

TUNED = (201, 202, 203, 204, 205, 206, 209, 212, *range(213, 219))
"""Virtual users for tuning the sensing and its rivals; never reported as a result.
`docs/evaluation.md` says what was chosen on which of them."""
REPORTED = tuple(range(313, 325))
"""The study's twelve: nothing was chosen on them. 301 to 312 were reported before."""
QUICK_USERS = TUNED[:3]
"""A quick run is for spotting regressions, and so for tuning users."""


@dataclass(frozen=True, slots=True)
class Task:
    """What a user does."""

    name: str
    scenario: str
    """Of the virtual camera."""
    seconds: float
    """Duration; approximate where it ends by itself or after its touches."""
    ends: bool = True
    """Whether it ends by itself."""
    touches: int | None = None
    """It ends after this many."""
    options: tuple[tuple[str, str], ...] = ()
    """As in a source's name: (("noise", "2"),)."""
    hands: int = 1
    """How many the tracker looks for."""
    all_fingers: bool = False
    """Every finger is a pointer, not the index fingers alone."""
    every_material: bool = False
    """On each material; else once per user."""


CALIBRATION = Task("calibration", "calibration", 42.0)
"""Comes before everything else, as for any user."""
POINTING = Task("pointing", "pointing", 89.0, ends=False, touches=64, every_material=True)
"""64 touches per user and material, half of them quick (5.2)."""
NOISY = (("noise", "2"),)
"""Twice the sensor's own noise."""
TASKS = (
    POINTING,
    Task("hover", "hover", 46.0),
    Task("hover-noise2", "hover", 46.0, options=NOISY),
    Task("pressure", "pressure", 48.0),
    Task("pressure-noise2", "pressure", 48.0, options=NOISY),
    Task("threshold", "threshold", 44.0),
    Task("awkward", "awkward", 55.0),
    Task("typing-accurate", "typing-accurate", 30.0, ends=False, hands=2),
    Task("typing", "typing", 30.0, ends=False, hands=2),
    Task("typing-fast", "typing-fast", 30.0, ends=False, hands=2),
    Task("ten-fingers", "ten-fingers", 30.0, ends=False, hands=2, all_fingers=True),
    Task("chaos", "chaos", 40.0, ends=False, hands=2, all_fingers=True),
)
"""The full matrix."""
QUICK_TASKS = (
    replace(POINTING, name="pointing-20", seconds=29.0, touches=20),
    Task("hover-5", "hover", 25.0, ends=False),
    Task("pressure-5", "pressure", 26.0, ends=False),
)
"""Three users with 20 touches each; each height and force once."""
QUICK_ONCE = 1
"""Only this many of the quick users hold levels: the run has to end within five minutes."""
ALL_TASKS = (*TASKS, *QUICK_TASKS)
"""All tasks that a cache can hold."""
LABELS = Task("labels", "labels", 60.0, ends=False, hands=2)
"""Taps at the times of real touches on a tablet; needs a file of them."""


NARROW, BINNED, WIDE = "NFOV_UNBINNED", "NFOV_2X2BINNED", "WFOV_2X2BINNED"


@dataclass(frozen=True, slots=True)
class Geometry:
    """The camera over one user's table."""

    height_mm: float
    pitch_deg: float
    yaw_deg: float
    mode: str = NARROW
    device: str = "kinect"

    @property
    def options(self) -> tuple[tuple[str, str], ...]:
        """As in a source's name."""
        return (
            ("camera_height_mm", f"{self.height_mm:g}"),
            ("camera_pitch_deg", f"{self.pitch_deg:g}"),
            ("camera_yaw_deg", f"{self.yaw_deg:g}"),
            ("mode", self.mode),
            ("device", self.device),
        )


GEOMETRY = {
    213: Geometry(350, 0, 0), 214: Geometry(500, 10, 5, BINNED), 215: Geometry(700, -8, 0),
    216: Geometry(430, 0, -12, WIDE), 217: Geometry(1000, 0, 0),
    218: Geometry(560, 20, 0, device="bolt"),
    313: Geometry(500, 0, 0), 314: Geometry(350, 5, 0), 315: Geometry(420, 0, 8, device="bolt"),
    316: Geometry(700, 0, 0), 317: Geometry(550, 20, 0), 318: Geometry(500, 0, 0, BINNED),
    319: Geometry(480, -10, 0), 320: Geometry(600, 0, -15, device="bolt"),
    321: Geometry(400, 0, 0, WIDE), 322: Geometry(850, 8, 0), 323: Geometry(1000, 0, 5, BINNED),
    324: Geometry(520, 12, 12, WIDE, "bolt"),
}  # fmt: skip
"""Height, tilt, depth mode and device of users from 213 on, chosen to mix; the seed draws the
camera of the others."""


FOLDER = re.compile(r"(\d+)-([a-z]+)(?:-([a-z]+))?(?:-(\d+(?:\.\d+)?)mm)?(?:-([A-Z][A-Z\d_]*))?")
"""The name of a user's folder, see `User.name`."""


@dataclass(frozen=True, slots=True)
class User:
    """A virtual user at a table of one material."""

    seed: int
    material: str
    sensor: str = "true"
    """Of the virtual camera."""
    height_mm: float | None = None
    """Of the virtual camera above the table; None: the user's own."""
    mode: str | None = None
    """Its depth mode; None: the user's own."""

    @property
    def name(self) -> str:
        """Of the folder."""
        parts = [str(self.seed), self.material]
        parts += [] if self.sensor == "true" else [self.sensor]
        parts += [] if self.height_mm is None else [f"{self.height_mm:g}mm"]
        parts += [] if self.mode is None else [self.mode]
        return "-".join(parts)

    def source(self, task: Task) -> str:
        """Return the source of the virtual camera."""
        options = {"seed": str(self.seed), "material": self.material, **dict(task.options)}
        if self.sensor != "true":
            options["sensor"] = self.sensor
        if self.seed in GEOMETRY:
            options |= GEOMETRY[self.seed].options
        if self.height_mm is not None:
            options["camera_height_mm"] = f"{self.height_mm:g}"
        if self.mode is not None:
            options["mode"] = self.mode
        return f"sim:{task.scenario}?" + "&".join(
            f"{key}={quote(text)}" for key, text in options.items()
        )


def user_of(name: str) -> User | None:
    """Return the user of a folder's name, None where it is not one."""
    named = FOLDER.fullmatch(name)
    if named is None:
        return None
    seed, material, sensor, height_mm, mode = named.groups()
    return User(
        int(seed), material, sensor or "true", None if height_mm is None else float(height_mm), mode
    )


Plan = Mapping[User, tuple[Task, ...]]
"""The tasks of each user, in order."""


def plan(
    users: Sequence[int] = REPORTED,
    materials: Sequence[str] = STUDIED,
    tasks: Sequence[Task] = TASKS,
    labels: Sequence[Path] = (),
    sensor: str = "true",
) -> dict[User, tuple[Task, ...]]:
    """Return the full study. `labels`: files of real taps; each user repeats one of them."""
    tasks_of = {}
    for index, seed in enumerate(users):
        for material in materials:
            once = material == own_material(seed, materials)
            mine = [task for task in tasks if once or task.every_material]
            if once and labels:
                mine.append(labelled(labels[index % len(labels)]))
            tasks_of[User(seed, material, sensor)] = tuple(mine)
    return {user: mine for user, mine in tasks_of.items() if mine}


def quick_plan(
    users: Sequence[int] = QUICK_USERS,
    materials: Sequence[str] = STUDIED,
    sensor: str = "kind",
) -> dict[User, tuple[Task, ...]]:
    """Return the small study: each user on one material.

    It compares changes of the code, so its default is the sensor that its bounds were measured on.
    """
    return {
        User(seed, own_material(seed, materials), sensor): tuple(
            task for task in QUICK_TASKS if task.every_material or index < QUICK_ONCE
        )
        for index, seed in enumerate(users)
    }


def seen_from(
    plan: Plan, heights_mm: Sequence[float], modes: Sequence[str]
) -> dict[User, tuple[Task, ...]]:
    """Return the plan with every user under each camera: all heights in all depth modes.

    Empty: the user's own height or mode.
    """
    return {
        replace(user, height_mm=height_mm, mode=mode): tasks
        for user, tasks in plan.items()
        for height_mm in heights_mm or (None,)
        for mode in modes or (None,)
    }


def own_material(seed: int, materials: Sequence[str]) -> str:
    """Return the material for tasks that a user does once; the next user has another."""
    return materials[seed % len(materials)]


def labelled(file: Path) -> Task:
    """Return the task of tapping at the times of a label file."""
    return replace(LABELS, name=f"labels-{file.stem}", options=(("labels", str(file)),))


def choose(wanted: Sequence[str], known: Sequence[str], what: str) -> tuple[str, ...]:
    """Return the wanted names; raises `UserError` for an unknown one."""
    for name in wanted:
        if name not in known:
            raise UserError(f"unknown {what} {name!r}; choose from: {', '.join(known)}")
    return tuple(wanted)
