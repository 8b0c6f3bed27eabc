"""What scenarios share: places out of view, and ways to come and go."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterator

import numpy as np

from halo_service.values import Finger, Side
from halo_service.virtual.motion import Segment, Timeline
from halo_service.virtual.room import HEIGHT_MM, WIDTH_MM, Room
from halo_service.virtual.scenario import PointingHand, Scenario
from halo_service.virtual.skeleton import FingerPose
from halo_service.virtual.timeline import SWAY_MM, TimelineReader

AWAY_ASIDE_MM = 120.0
"""How much farther from the middle it is at the other edges: the image is wider there."""
AWAY_RIGHT_MM = 40.0
"""How far right of the body's middle a right hand is out of view, chosen."""

Script = Callable[[Timeline], Iterator[Segment]]


def away(room: Room, side: Side) -> FingerPose:
    """Next to the user's body, out of the camera's view."""
    turn = np.radians(room.seat_deg)
    right = AWAY_RIGHT_MM if side is Side.RIGHT else -AWAY_RIGHT_MM
    back = away_mm(room)
    x = WIDTH_MM / 2.0 + right * float(np.cos(turn)) - back * float(np.sin(turn))
    y = HEIGHT_MM / 2.0 + right * float(np.sin(turn)) + back * float(np.cos(turn))
    return FingerPose(x, y, 60.0, 0.0, 40.0, 0.0)


def away_mm(room: Room) -> float:
    """How far from the surface's middle a hand out of view is."""
    aside = 1.0 - max(0.0, float(np.cos(np.radians(room.seat_deg))))
    field = 1.9 if room.mode.startswith("WFOV") else 0.75
    return 80.0 + field * room.camera_height_mm + AWAY_ASIDE_MM * aside


def is_away(room: Room, aim: FingerPose) -> bool:
    """Whether a fingertip is about as far out as a hand out of view."""
    out = np.hypot(aim.x_mm - WIDTH_MM / 2.0, aim.y_mm - HEIGHT_MM / 2.0)
    return bool(out > away_mm(room) - SWAY_MM)


def from_seat(room: Room, x_mm: float, y_mm: float) -> dict[str, float]:
    """The place that a user at another edge has where one at the near edge has (x, y)."""
    turn, half = np.radians(room.seat_deg), np.array([WIDTH_MM, HEIGHT_MM]) / 2.0
    right, near = (np.array([x_mm, y_mm]) - half) / half
    c, s = np.cos(turn), np.sin(turn)
    x, y = half + half * np.array([c * right - s * near, s * right + c * near])
    return {"x_mm": float(x), "y_mm": float(y)}


def at_near_edge(room: Room) -> Room:
    """The room with the user at the near edge: whoever types or drums faces the keys."""
    turned = (room.seat_deg + 45.0) % 90.0 - 45.0
    return dataclasses.replace(room, seat_deg=turned)


def pointer(
    room: Room,
    rng: np.random.Generator,
    script: Script,
    side: Side | None = None,
    start: FingerPose | None = None,
    finger: Finger = Finger.INDEX,
) -> tuple[Timeline, PointingHand]:
    """A hand that follows a script with one finger; from out of view, unless `start` says else."""
    hand = side or room.dominant
    timeline = Timeline(rng, start or away(room, hand), hand, finger)
    return timeline, PointingHand(
        room.user, timeline, TimelineReader(script(timeline), rng, room.seat_deg)
    )


def solo(
    room: Room, rng: np.random.Generator, script: Script, start: FingerPose | None = None
) -> Scenario:
    """A scenario for the dominant index finger alone."""
    timeline, motion = pointer(room, rng, script, start=start)
    return Scenario(room, [motion], timeline.steps)


def comfortable(p: Timeline) -> dict[str, float]:
    """An angle that people like; the paper's hands were free (5.1), the range is chosen."""
    inwards = -1.0 if p.side is Side.RIGHT else 1.0
    return {
        "pitch_deg": p.rng.uniform(32.0, 58.0),
        "yaw_deg": inwards * p.rng.uniform(-8.0, 28.0),
    }


def somewhere(p: Timeline) -> dict[str, float]:
    """A place on the surface, 4 cm off its edges, and a comfortable angle."""
    place = {"x_mm": p.rng.uniform(40.0, 260.0), "y_mm": p.rng.uniform(40.0, 160.0)}
    return place | comfortable(p)
