"""The person that a seed draws: hands, and how a fingertip's halo grows.

Rule: each draw has its own random stream, so a new one changes no other. Plain users go with the
`kind` sensor, for unit tests; everyone else is varied.
"""

from __future__ import annotations

import dataclasses
import zlib
from statistics import NormalDist

import numpy as np

from halo_service.values import Finger
from halo_service.virtual.halo import FAMILIES, HaloCurve
from halo_service.virtual.materials import MATERIALS, STUDIED
from halo_service.virtual.skeleton import User

GIRTHS = (0.85, 0.92, 1.0, 1.08, 1.15)
"""In five steps, so that a process builds few meshes."""
NAILS_OVER_MM = (2.0, 5.0, 8.0)
LIKE_A_TABLE = 0.4
"""Share of users whose skin is as bright as one of the studied materials, chosen: bright on
bright and dark on dark are hard to segment, so they are drawn more often than they are met."""
SKIN_RANGE = 0.35, 0.82
"""Infrared reflectance of such a skin."""


def stream(seed: int, what: str) -> np.random.Generator:
    """The random numbers of one named draw."""
    return np.random.default_rng([seed, zlib.crc32(what.encode())])


def draw_user(seed: int) -> User:
    """A plain user: size within two thirds of adults, all skin types."""
    draw = stream(seed, "user")
    depth = draw.uniform(0.0, 1.0)
    light, dark = np.array([0.52, 0.64, 0.86]), np.array([0.16, 0.22, 0.36])
    tone = light + (dark - light) * depth
    return User(
        size=float(draw.uniform(0.92, 1.08)),
        # In five steps, so that a process builds few meshes.
        girth=float(draw.choice([0.9, 0.95, 1.0, 1.05, 1.1])),
        pad_g=float(draw.uniform(70.0, 120.0)),
        pad_mm=float(draw.uniform(1.8, 2.6)),
        skin=float(0.62 - 0.14 * depth + draw.normal(0.0, 0.02)),
        tone=(float(tone[0]), float(tone[1]), float(tone[2])),
        skin_offset_mm=_skin_offset_mm(draw.uniform(0.0, 1.0)),
        nail_mm=float(draw.uniform(7.0, 13.0)),
        sleeve_mm=float(draw.uniform(30.0, 120.0)) if draw.random() < 0.5 else None,
        curl=float(draw.uniform(0.3, 1.0)),
    )


SKIN_OFFSET_MM, SKIN_SPREAD = 9.0, 0.27
"""Median of the users' offset, mm, and the spread of its logarithm: 5 to 15 mm hold 95 of 100
users. Owners report 8 to 15 mm (Azure-Kinect-Sensor-SDK #1341)."""


def _skin_offset_mm(share: float) -> float:
    """The offset below which this share of the users lies; log-normal."""
    deviations = NormalDist().inv_cdf(float(np.clip(share, 0.001, 0.999)))
    return float(np.clip(SKIN_OFFSET_MM * np.exp(SKIN_SPREAD * deviations), 5.0, 15.0))


def draw_varied_user(seed: int) -> User:
    """The same person with wider hands: girth, curl, thumb, nails, sleeves, rings, skin."""
    draw = stream(seed, "varied user")
    user = dataclasses.replace(
        draw_user(seed),
        girth=float(draw.choice(GIRTHS)),
        curl=_curl(draw),
        thumb_out=float(draw.uniform(0.0, 1.0)),
        nail_over_mm=float(draw.choice(NAILS_OVER_MM)) if draw.random() < 0.3 else 0.0,
        sleeve_mm=float(draw.uniform(-30.0, 120.0)) if draw.random() < 0.6 else None,
        sleeve_infrared=float(draw.uniform(0.2, 0.8)),
        rings=_rings(draw),
    )
    return _like_a_table(user, stream(seed, "skin"))


def _curl(draw: np.random.Generator) -> float:
    """A quarter of the users make a fist, a quarter let the other fingers hang."""
    kind, between = draw.random(), float(draw.uniform(0.0, 1.0))
    return {0: 1.0, 1: 0.0}.get(int(4.0 * kind), between)


def _rings(draw: np.random.Generator) -> tuple[Finger, ...]:
    """None for two thirds of the users, else one or two."""
    count = int(draw.choice([0, 0, 0, 0, 1, 2]))
    fingers = draw.choice([f.value for f in Finger], size=count, replace=False)
    return tuple(Finger(int(f)) for f in sorted(fingers))


def _like_a_table(user: User, draw: np.random.Generator) -> User:
    """For some users, skin as bright as a material, in infrared and in colour."""
    material = MATERIALS[str(draw.choice(STUDIED))]
    share, infrared = draw.random(), draw.uniform(0.95, 1.05)
    if share >= LIKE_A_TABLE:
        return user
    times = float(np.mean(material.colour) / np.mean(user.tone))
    blue, green, red = (float(np.clip(times * part, 0.03, 0.95)) for part in user.tone)
    skin = float(np.clip(material.infrared * infrared, *SKIN_RANGE))
    return dataclasses.replace(user, skin=skin, tone=(blue, green, red))


def draw_curve(seed: int) -> HaloCurve:
    """A plain halo: a bell under the fingertip, nearly the same all over the table."""
    draw = stream(seed, "halo")
    return HaloCurve(
        family=str(draw.choice(sorted(FAMILIES))),
        onset_mm=float(draw.uniform(19.0, 22.0)),
        gain=float(draw.uniform(0.9, 1.15)),
        press_g=float(draw.uniform(150.0, 300.0)),
        across_deg=float(draw.uniform(0.0, 360.0)),
    )


def draw_varied_curve(seed: int) -> HaloCurve:
    """The same halo with a changing footprint, a weak corner, other presses; half are odd."""
    draw = stream(seed, "varied halo")
    curve = dataclasses.replace(
        draw_curve(seed),
        wider_high=float(draw.uniform(0.0, 0.5)),
        wider_pressed=float(draw.uniform(0.0, 0.35)),
        corner_fall=float(draw.uniform(0.0, 0.45)),
        corner=int(draw.integers(4)),
        press_power=float(draw.uniform(0.5, 1.0)) if draw.random() < 0.5 else 0.0,
        press_saturates=bool(draw.random() < 0.5),
    )
    return _odd(curve, draw) if draw.random() < 0.5 else curve


def _odd(curve: HaloCurve, draw: np.random.Generator) -> HaloCurve:
    return dataclasses.replace(
        curve,
        shift_mm=float(draw.uniform(1.0, 5.0)),
        stretch=float(draw.uniform(1.2, 1.8)),
        lopsided=float(draw.uniform(-0.3, 0.3)),
        glow_mm=float(draw.uniform(1.0, 2.0)),
        glow_reach_mm=float(draw.uniform(25.0, 50.0)),
    )
