"""What the paper says about its camera, next to what the virtual one does.

Rule: each row is a statement, its section, how it is measured on frames, and the range in
which it holds. Where one does not hold, the table says so.
"""

from __future__ import annotations

import functools
import itertools
from collections.abc import Callable
from dataclasses import dataclass, replace

from halo_service.virtual.curves import Bench, Regions
from halo_service.virtual.halo import HaloCurve
from halo_service.virtual.materials import STUDIED
from halo_service.virtual.room import Room

ASIDE_DEG = -40.0
"""Yaw of the finger where the camera's pitch changes: pointing straight ahead, the user's own arm
hides the fingertip from a camera that looks forward by 30 degrees and more. The paper does not
say how its finger lay."""
SEEN_MM = 1.0
"""Mean depth around the pad from which on a halo counts as there; about one sigma of the noise."""


@dataclass(frozen=True, slots=True)
class Statement:
    """One row."""

    says: str
    where: str
    """Section of the paper."""
    measure: Callable[[], float]
    unit: str
    least: float
    most: float


@dataclass(frozen=True, slots=True)
class Finding:
    """A statement and what was measured."""

    statement: Statement
    value: float

    @property
    def holds(self) -> bool:
        """Whether the value is in the statement's range."""
        return self.statement.least <= self.value <= self.statement.most


def check() -> list[Finding]:
    """Measure them all; about 20 s."""
    return [Finding(statement, statement.measure()) for statement in STATEMENTS]


REFERENCE = Room(seed=1)
"""Plain paper, 0.5 m, an average user, on the true sensor."""


@functools.lru_cache(maxsize=64)
def bench(**place: float | str) -> Bench:
    """The reference room (plain paper, 0.5 m, a middling user) with something changed."""
    family = place.pop("family", None)
    room = replace(REFERENCE, **place)  # type: ignore[arg-type]  # by name
    return Bench(room if family is None else replace(room, curve=HaloCurve(family=str(family))))


@functools.lru_cache(maxsize=64)
def regions(yaw_deg: float = 0.0, **place: float) -> Regions:
    """Sensing regions with the camera elsewhere, of those at 0.5 m straight above."""
    return bench(**place).regions(yaw_deg=yaw_deg).relative(bench().regions(yaw_deg=yaw_deg))


def _order() -> float:
    """The smallest step from a state to the next, of the signal in touch."""
    at = bench().states()
    steps = (at["subtle"] - at["hover"], at["touch"] - at["subtle"], at["pressure"] - at["touch"])
    return min(steps) / at["touch"]


def _onset() -> float:
    """The greatest height at which a halo is there, to half a millimetre."""
    low, high = 5.0, 35.0
    while high - low > 0.5:
        middle = (low + high) / 2.0
        low, high = (middle, high) if bench().dent_mm(middle) > SEEN_MM else (low, middle)
    return low


def _of_paper(material: str) -> float:
    """Signal in touch."""
    return bench(material=material).signal(0.0, 25.0) / bench().signal(0.0, 25.0)


def _growth() -> float:
    """The smallest growth of the signal from one force of the study to the next, in %."""
    signals = [bench().signal(0.0, 385.0 * level) for level in (0.1, 0.25, 0.5, 0.75, 1.0)]
    return min(100.0 * (b / a - 1.0) for a, b in itertools.pairwise(signals))


def _others(extreme: Callable[..., float], but: str) -> float:
    return extreme(_of_paper(material) for material in STUDIED if material != but)


INFINITE = float("inf")

STATEMENTS = (
    Statement(
        "four states in order: hover, subtle, touch, pressure", "4.3.5", _order, "", 0.1, INFINITE
    ),
    Statement("halo appears at about 2 cm", "4.1.3", _onset, "mm", 15.0, 22.0),
    Statement(
        "halo just visible at about 1 cm (threshold 8)",
        "4.3.5",
        lambda: bench().signal(10.0) / bench().signal(1.0),
        "of subtle",
        0.001,
        0.2,
    ),
    Statement("signal grows with force up to 385 g", "4.1.3, 5.2", _growth, "%", 2.0, INFINITE),
    Statement(
        "weak below 15 degrees of finger pitch",
        "4.3.4",
        lambda: bench().signal(1.0, pitch_deg=5.0) / bench().signal(1.0, pitch_deg=45.0),
        "of 45 degrees",
        0.0,
        0.5,
    ),
    Statement(
        "80 cm: approach below half",
        "6.4",
        lambda: regions(camera_height_mm=800.0).hover,
        "of 50 cm",
        0.0,
        0.5,
    ),
    Statement(
        "100 cm: touch above three quarters",
        "6.4",
        lambda: regions(camera_height_mm=1000.0).touch,
        "of 50 cm",
        0.75,
        1.25,
    ),
    Statement(
        "70 cm: pressure above three quarters",
        "6.4",
        lambda: regions(camera_height_mm=700.0).pressure,
        "of 50 cm",
        0.75,
        1.25,
    ),
    Statement(
        "yaw 25: approach below half",
        "6.4",
        lambda: regions(camera_yaw_deg=25.0).hover,
        "of 0",
        0.0,
        0.5,
    ),
    Statement(
        "yaw 50: touch above three quarters",
        "6.4",
        lambda: regions(camera_yaw_deg=50.0).touch,
        "of 0",
        0.75,
        1.25,
    ),
    Statement(
        "yaw 35: pressure above three quarters",
        "6.4",
        lambda: regions(camera_yaw_deg=35.0).pressure,
        "of 0",
        0.75,
        1.25,
    ),
    Statement(
        "pitch 15: approach below half",
        "6.4",
        lambda: regions(ASIDE_DEG, camera_pitch_deg=15.0).hover,
        "of 0",
        0.0,
        0.5,
    ),
    Statement(
        "pitch 45: touch above three quarters",
        "6.4",
        lambda: regions(ASIDE_DEG, camera_pitch_deg=45.0).touch,
        "of 0",
        0.75,
        1.25,
    ),
    Statement(
        "pitch 45: pressure above three quarters",
        "6.4",
        lambda: regions(ASIDE_DEG, camera_pitch_deg=45.0).pressure,
        "of 0",
        0.75,
        1.25,
    ),
    Statement(
        "pitch -35 to 0: pressure amplified",
        "6.4",
        lambda: min(regions(ASIDE_DEG, camera_pitch_deg=p).pressure for p in (-30.0, -20.0, -10.0)),
        "of 0",
        1.0,
        1.6,
    ),
    Statement(
        "foam: much less than any other material",
        "6.4",
        lambda: _of_paper("foam") / _others(min, "foam"),
        "of the next",
        0.0,
        0.8,
    ),
    Statement(
        "suede sleeve: much more than any other",
        "6.4",
        lambda: _of_paper("suede") / _others(max, "suede"),
        "of the next",
        1.3,
        INFINITE,
    ),
    Statement(
        "a thin puddle makes no difference",
        "4.5",
        lambda: _of_paper("wet") / _of_paper("wood"),
        "of dry",
        0.93,
        1.07,
    ),
    Statement("mirrors: none", "4.1.1", lambda: _of_paper("mirror"), "of paper", 0.0, 0.01),
)
