"""`chaos`: sleeves, palms, fists, objects on the table, hands that come and go, and one hand
that taps in between."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator

import numpy as np

from halo_service.values import Side
from halo_service.virtual.bodies import Body, cup
from halo_service.virtual.hand import fist, resting
from halo_service.virtual.motion import Contact, Segment, Timeline
from halo_service.virtual.room import Room
from halo_service.virtual.scenario import Scenario, other
from halo_service.virtual.scenarios.common import away, from_seat, pointer, somewhere
from halo_service.virtual.skeleton import HandPose, User
from halo_service.virtual.timeline import TimelineReader

SLEEVE_MM = 45.0
"""How far a shirt's cuff ends above the wrist, chosen."""
CUP_S = (20.0, 32.0)
"""When a second mug is on the table, and when it leaves; chosen."""


def dressed(room: Room) -> Room:
    """The room with sleeves on, and a mug and a sheet of paper on the table."""
    user = dataclasses.replace(room.user, sleeve_mm=SLEEVE_MM)
    return dataclasses.replace(room, user=user, props=room.props or ("cup", "sheet"))


class RestingHand:
    """A hand that comes, rests its palm or its fist on the table, and goes. No finger touches."""

    def __init__(self, user: User, side: Side, track: TimelineReader, closed: bool) -> None:
        self._user, self._side, self._track = user, side, track
        self._shape = fist if closed else resting

    def pose(self, t_s: float) -> HandPose | None:
        """On the table where its timeline has height 0."""
        at = self._track.at(t_s)
        pose = self._shape(self._user, self._side, at.x_mm, at.y_mm, at.yaw_deg)
        raised = pose.surface_from_hand.copy()
        raised[2, 3] -= at.height_mm
        return dataclasses.replace(pose, surface_from_hand=raised)

    def started_contacts(self, t_s: float) -> list[Contact]:
        """Fingertips never touch."""
        return []

    def tools(self, t_s: float) -> list[Body]:
        """No objects."""
        return []

    @property
    def finished(self) -> bool:
        """Never."""
        return False


def chaos(room: Room, rng: np.random.Generator) -> Scenario:
    """Never ends; the mug comes once."""
    tapper = pointer(room, rng, lambda p: _comes_and_goes(p, room))
    side = other(room.dominant)
    motions = [tapper[1]]
    late = []
    for delay_s, closed in ((4.0, False), (17.0, True)):
        timeline = Timeline(rng, away(room, side), side)
        late.append(
            RestingHand(
                room.user,
                side,
                TimelineReader(_visit(timeline, room, delay_s), rng, room.seat_deg),
                closed,
            )
        )
    return Scenario(room, [*motions, *late], tapper[0].steps, _mug)


def _mug(t_s: float) -> list[Body]:
    return [cup(40.0, 40.0, 36.0, 80.0)] if CUP_S[0] <= t_s < CUP_S[1] else []


def _comes_and_goes(p: Timeline, room: Room) -> Iterator[Segment]:
    home = {"x_mm": p.pose.x_mm, "y_mm": p.pose.y_mm, "height_mm": p.pose.height_mm}
    yield from p.hold(2.5)
    while True:
        yield from p.reach(p.rng.uniform(0.7, 1.3), **_own_half(p, room), height_mm=20.0)
        for _ in range(int(p.rng.integers(3, 7))):
            yield from p.tap(p.rng.uniform(0.1, 0.4), p.rng.uniform(20, 150), lift_mm=18.0)
            yield from p.reach(p.rng.uniform(0.3, 0.7), lift_mm=12.0, **_own_half(p, room))
        yield from p.reach(1.0, **home)
        yield from p.hold(p.rng.uniform(0.5, 3.0))


def _own_half(p: Timeline, room: Room) -> dict[str, float]:
    """A place that the other hand leaves free."""
    x = p.rng.uniform(30.0, 105.0)
    place = somewhere(p)
    x = 300.0 - x if p.side is Side.RIGHT else x
    return place | from_seat(room, x, place["y_mm"])


def _visit(p: Timeline, room: Room, delay_s: float) -> Iterator[Segment]:
    """Every 26 s: lie on the table for a while, move about, and leave."""
    home = {"x_mm": p.pose.x_mm, "y_mm": p.pose.y_mm, "height_mm": 60.0}
    x = 60.0 if p.side is Side.LEFT else 240.0
    yield from p.hold(delay_s)
    while True:
        yield from p.reach(1.2, **from_seat(room, x, 110.0), height_mm=30.0)
        yield from p.reach(0.5, height_mm=0.0)
        yield from p.hold(2.5)
        moved = from_seat(room, x + p.rng.uniform(-20.0, 20.0), 90.0)
        yield from p.reach(1.5, **moved, height_mm=0.0)
        yield from p.hold(1.5)
        yield from p.reach(1.2, **home)
        yield from p.hold(26.0 - 8.4)
