"""A play: actors in a room, read forwards in time.

Rule: pure. It knows the truth; the sensor is handed bodies and nothing else.
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
from halo_service.virtual.motion import Contact, Performer, Step
from halo_service.virtual.room import Room
from halo_service.virtual.skeleton import HandPose, PosedHand, User, posed, tip_of
from halo_service.virtual.track import Track

VELOCITY_S = 0.01
"""Over which a hand's velocity is taken."""


class Actor(Protocol):
    """One hand and what it does."""

    def pose(self, t_s: float) -> HandPose | None:
        """At a time; None where it is not there. Times go back by less than a second."""

    def begun(self, t_s: float) -> list[Contact]:
        """Touches that have begun since the last call; their place is filled in by the play."""

    def tools(self, t_s: float) -> list[Body]:
        """What it has brought with it."""

    @property
    def finished(self) -> bool:
        """Whether nothing more will happen."""


class Pointer:
    """A hand that points with one finger."""

    def __init__(self, user: User, performer: Performer, track: Track) -> None:
        self._user, self._performer, self._track = user, performer, track

    def pose(self, t_s: float) -> HandPose | None:
        """Where the finger's time line wants it."""
        performer = self._performer
        return pointing(
            self._user,
            performer.side,
            self._track.at(t_s),
            finger=performer.finger,
            curl=self._user.curl,
        )

    def begun(self, t_s: float) -> list[Contact]:
        """From the time line."""
        return self._track.begun(t_s)

    def tools(self, t_s: float) -> list[Body]:
        """The calibration wedge, where the finger rests on it."""
        if self._track.tool_at(t_s) != "wedge":
            return []
        aim = self._track.at(t_s)
        return [wedge(aim.x_mm, aim.y_mm, aim.yaw_deg)]

    @property
    def finished(self) -> bool:
        """Whether the time line has ended."""
        return self._track.finished


@dataclass(frozen=True, slots=True, eq=False)
class Stage:
    """Everything in view at one moment."""

    hands: tuple[PosedHand, ...]
    things: tuple[Body, ...]


Things = Callable[[float], Sequence[Body]]


class Play:
    """A scenario as it is being played."""

    def __init__(
        self,
        room: Room,
        actors: Sequence[Actor],
        steps: list[Step] | None = None,
        things: Things | None = None,
        listen: Callable[[object], None] | None = None,
    ) -> None:
        self._room = room
        self._actors = actors
        self._things = things
        self._listen = listen
        self.steps = steps if steps is not None else []
        """What has been finished so far, in order."""
        self._contacts: list[Contact] = []

    def at(self, t_s: float) -> Stage:
        """What is in view at a time; times may not go back by more than half a second."""
        hands, things = [], list(self._things(t_s)) if self._things else []
        for actor in self._actors:
            pose = actor.pose(t_s)
            if pose is not None:
                hands.append(posed(self._room.user, pose, _velocity(actor, pose, t_s)))
                things += actor.tools(t_s)
            self._contacts += [self._placed(actor, c) for c in actor.begun(t_s)]
        return Stage(tuple(hands), tuple(things))

    def ended_contacts(self, t_s: float) -> list[Contact]:
        """Touches that ended before a time and have not been handed out yet."""
        ended = [c for c in self._contacts if c.to_s <= t_s]
        self._contacts = [c for c in self._contacts if c.to_s > t_s]
        return sorted(ended, key=lambda c: c.from_s)

    @property
    def finished(self) -> bool:
        """Whether nobody will do anything more; an empty room is never finished."""
        return bool(self._actors) and all(actor.finished for actor in self._actors)

    def tell(self, message: object) -> None:
        """Hand a message to the play, if it listens."""
        if self._listen is not None:
            self._listen(message)

    def _placed(self, actor: Actor, contact: Contact) -> Contact:
        """A touch, with its place as the skin had it rather than as it was aimed."""
        pose = actor.pose(contact.from_s)
        if pose is None:
            return contact
        pad = tip_of(self._room.user, pose, contact.finger)
        return dataclasses.replace(contact, x_mm=float(pad[0]), y_mm=float(pad[1]))


def _velocity(actor: Actor, pose: HandPose, t_s: float) -> Floats:
    """(3,) mm/s."""
    before = actor.pose(t_s - VELOCITY_S) if t_s >= VELOCITY_S else None
    if before is None:
        return np.zeros(3)
    moved = pose.surface_from_hand[:3, 3] - before.surface_from_hand[:3, 3]
    return np.asarray(moved / VELOCITY_S, dtype=np.float64)


def other(side: Side) -> Side:
    """The other hand."""
    return Side.LEFT if side is Side.RIGHT else Side.RIGHT
