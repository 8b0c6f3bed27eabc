"""What scenarios share: places out of view, and ways to come and go."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np

from halo_service.values import Finger, Side
from halo_service.virtual.motion import Segment, Timeline
from halo_service.virtual.room import Room
from halo_service.virtual.scenario import PointingHand, Scenario
from halo_service.virtual.skeleton import FingerPose
from halo_service.virtual.timeline import TimelineReader

Script = Callable[[Timeline], Iterator[Segment]]


def away(room: Room, side: Side) -> FingerPose:
    """Next to the user's body, out of the camera's view."""
    x = 190.0 if side is Side.RIGHT else 110.0
    return FingerPose(x, 180.0 + 0.75 * room.camera_height_mm, 60.0, 0.0, 40.0, 0.0)


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
    return timeline, PointingHand(room.user, timeline, TimelineReader(script(timeline), rng))


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
