"""A scenario: moving hands in a room, read forwards in time.

Rule: pure. It holds the truth; the sensor gets bodies only.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from halo_service.values import Side
from halo_service.virtual.bodies import Body, wedge
from halo_service.virtual.hand import pointing
from halo_service.virtual.mesh import Floats
from halo_service.virtual.motion import Contact, Step, Timeline
from halo_service.virtual.room import Room
from halo_service.virtual.skeleton import HandPose, PosedHand, User, posed, tip_of
from halo_service.virtual.timeline import TimelineReader

VELOCITY_S = 0.01
"""Over which a hand's velocity is taken."""


class HandMotion(Protocol):
    """One hand and how it moves."""

    def pose(self, t_s: float) -> HandPose | None:
        """Pose at a time; None where the hand is absent. Times go back by less than a second."""

    def started_contacts(self, t_s: float) -> list[Contact]:
        """Touches that started since the last call; the scenario fills in their place."""

    def tools(self, t_s: float) -> list[Body]:
        """Objects that the hand uses."""

    @property
    def finished(self) -> bool:
        """Whether the motion has ended."""


class PointingHand:
    """A hand that points with one finger."""

    def __init__(self, user: User, timeline: Timeline, track: TimelineReader) -> None:
        self._user, self._timeline, self._track = user, timeline, track

    def pose(self, t_s: float) -> HandPose | None:
        """The pose that the timeline gives."""
        timeline = self._timeline
        return pointing(
            self._user,
            timeline.side,
            self._track.at(t_s),
            finger=timeline.finger,
            curl=self._user.curl,
        )

    def started_contacts(self, t_s: float) -> list[Contact]:
        """From the timeline."""
        return self._track.started_contacts(t_s)

    def tools(self, t_s: float) -> list[Body]:
        """The calibration wedge, where the finger rests on it."""
        if self._track.tool_at(t_s) != "wedge":
            return []
        aim = self._track.at(t_s)
        return [wedge(aim.x_mm, aim.y_mm, aim.yaw_deg)]

    @property
    def finished(self) -> bool:
        """Whether the timeline has ended."""
        return self._track.finished


@dataclass(frozen=True, slots=True, eq=False)
class Snapshot:
    """All hands and objects in view at one time."""

    hands: tuple[PosedHand, ...]
    things: tuple[Body, ...]


Things = Callable[[float], Sequence[Body]]


class Scenario:
    """A running scenario."""

    def __init__(
        self,
        room: Room,
        motions: Sequence[HandMotion],
        steps: list[Step] | None = None,
        things: Things | None = None,
        on_message: Callable[[object], None] | None = None,
    ) -> None:
        self._room = room
        self._motions = motions
        self._things = things
        self._on_message = on_message
        self.steps = steps if steps is not None else []
        """Finished steps, in order."""
        self._contacts: list[Contact] = []
        self._from_canvas = None if room.installation.alone else from_canvas(room)

    def at(self, t_s: float) -> Snapshot:
        """What is in view at a time; times may not go back by more than half a second."""
        hands, things = [], list(self._things(t_s)) if self._things else []
        for motion in self._motions:
            pose = self._pose(motion, t_s)
            if pose is not None:
                hands.append(posed(self._room.user, pose, self._velocity(motion, pose, t_s)))
                things += motion.tools(t_s)
            self._contacts += [self._placed(motion, c) for c in motion.started_contacts(t_s)]
        return Snapshot(tuple(hands), tuple(things))

    def ended_contacts(self, t_s: float) -> list[Contact]:
        """Touches that ended before a time and were not returned yet."""
        ended = [c for c in self._contacts if c.to_s <= t_s]
        self._contacts = [c for c in self._contacts if c.to_s > t_s]
        return sorted(ended, key=lambda c: c.from_s)

    @property
    def finished(self) -> bool:
        """Whether all motions have ended; an empty room never ends."""
        return bool(self._motions) and all(motion.finished for motion in self._motions)

    def send(self, message: object) -> None:
        """Pass a message to the scenario, if it accepts messages."""
        if self._on_message is not None:
            self._on_message(message)

    def _placed(self, motion: HandMotion, contact: Contact) -> Contact:
        """The touch at the place where the posed fingertip really is, not where it was aimed."""
        pose = self._pose(motion, contact.from_s)
        if pose is None:
            return contact
        pad = tip_of(self._room.user, pose, contact.finger)
        return dataclasses.replace(contact, x_mm=float(pad[0]), y_mm=float(pad[1]))

    def _velocity(self, motion: HandMotion, pose: HandPose, t_s: float) -> Floats:
        """(3,) mm/s."""
        before = self._pose(motion, t_s - VELOCITY_S) if t_s >= VELOCITY_S else None
        if before is None:
            return np.zeros(3)
        moved = pose.surface_from_hand[:3, 3] - before.surface_from_hand[:3, 3]
        return np.asarray(moved / VELOCITY_S, dtype=np.float64)

    def _pose(self, motion: HandMotion, t_s: float) -> HandPose | None:
        """The pose in this camera's surface frame; motions of installations are on the canvas."""
        pose = motion.pose(t_s)
        if pose is None or self._from_canvas is None:
            return pose
        return dataclasses.replace(
            pose, surface_from_hand=self._from_canvas @ pose.surface_from_hand
        )


def from_canvas(room: Room) -> Floats:
    """(4, 4) the place of the room's camera: canvas to surface, mm."""
    return np.asarray(np.linalg.inv(room.place.canvas_from_surface), dtype=np.float64)


def other(side: Side) -> Side:
    """The other hand."""
    return Side.LEFT if side is Side.RIGHT else Side.RIGHT
