"""`ten-fingers`: both hands open, every finger taps in turn, without end."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from halo_service.values import Finger, Side
from halo_service.virtual.bodies import Body
from halo_service.virtual.hand import open_hand
from halo_service.virtual.motion import Contact, Segment, Timeline, bump
from halo_service.virtual.room import Room
from halo_service.virtual.scenario import Scenario
from halo_service.virtual.scenarios.common import away, from_seat
from halo_service.virtual.skeleton import FingerPose, HandPose, User
from halo_service.virtual.timeline import SWAY_MM, TimelineReader

REST_MM = 11.0
"""Height of the fingers that wait, chosen; a tapping finger's neighbours move along a little."""
HANG_DEG = 55.0
"""Pitch of the index finger as the hand hangs over the table, chosen."""
SPREAD_DEG = 6.0


class OpenHand:
    """A hand with five timelines, which give each finger's height and force."""

    def __init__(
        self, user: User, side: Side, palm: TimelineReader, fingers: dict[Finger, TimelineReader]
    ) -> None:
        self._user, self._side = user, side
        self._palm, self._fingers = palm, fingers

    def pose(self, t_s: float) -> HandPose | None:
        """The palm where its timeline has it, the fingers at their heights above the table."""
        palm = self._palm.at(t_s)
        lifted = max(0.0, palm.height_mm - REST_MM - SWAY_MM)  # fingers do not sway with it
        aims = {finger: track.at(t_s) for finger, track in self._fingers.items()}
        return open_hand(
            self._user,
            self._side,
            palm,
            {finger: aim.height_mm + lifted for finger, aim in aims.items()},
            {finger: aim.force_g for finger, aim in aims.items()},
            SPREAD_DEG,
        )

    def started_contacts(self, t_s: float) -> list[Contact]:
        """Of all fingers."""
        return [
            contact for track in self._fingers.values() for contact in track.started_contacts(t_s)
        ]

    def tools(self, t_s: float) -> list[Body]:
        """No objects."""
        return []

    @property
    def finished(self) -> bool:
        """Never."""
        return False


def ten_fingers(room: Room, rng: np.random.Generator) -> Scenario:
    """Five fingers each, at most one of a hand down at a time."""
    return Scenario(room, [_hand(room, rng, side) for side in (Side.LEFT, Side.RIGHT)])


def _hand(room: Room, rng: np.random.Generator, side: Side) -> OpenHand:
    palm = Timeline(rng, away(room, side), side)
    order = [Finger(int(k)) for _ in range(60) for k in rng.permutation(5)]
    rhythm = rng.uniform(0.55, 0.8)
    fingers = {}
    for finger in Finger:
        start = FingerPose(0.0, 0.0, REST_MM)
        timeline = Timeline(rng, start, side, finger)
        fingers[finger] = TimelineReader(_taps(timeline, order, rhythm), rng)
    return OpenHand(room.user, side, TimelineReader(_palm(palm, room), rng, room.seat_deg), fingers)


def _palm(p: Timeline, room: Room) -> Iterator[Segment]:
    """Comes, and then drifts about a little between the taps."""
    x = 225.0 if p.side is Side.RIGHT else 75.0
    inwards = -10.0 if p.side is Side.RIGHT else 10.0
    angles = {"pitch_deg": HANG_DEG, "yaw_deg": inwards}
    yield from p.hold(2.5)
    yield from p.reach(1.3, **from_seat(room, x, 70.0), height_mm=REST_MM, **angles)
    while True:
        yield from p.hold(30.0)


def _taps(p: Timeline, order: list[Finger], rhythm_s: float) -> Iterator[Segment]:
    """This finger's share of the common order, over and over."""
    yield from p.hold(4.5)
    begin_s, turn = p.now_s, 0
    while True:
        if order[turn % len(order)] is p.finger:
            yield from p.hold(begin_s + turn * rhythm_s - p.now_s + p.rng.uniform(0.02, 0.1))
            yield from p.strike(p.rng.uniform(0.07, 0.1))
            yield from p.press(p.rng.uniform(0.1, 0.25), bump(p.rng.uniform(25.0, 120.0)))
            yield from p.reach(0.12, height_mm=REST_MM)
        turn += 1
