"""`hand`: a finger that is played by messages, one each time it moves.

Rule: a message is (hand, finger, x_mm, y_mm, height_mm, force_g), as the control port's
`/halo/1/sim/finger` has it. A force above 0 puts the finger on the table whatever its height; a
negative height takes the hand away.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

import numpy as np

from halo_service.errors import UserError
from halo_service.values import Finger, Side
from halo_service.virtual.bodies import Body
from halo_service.virtual.hand import pointing
from halo_service.virtual.motion import Contact
from halo_service.virtual.room import Room
from halo_service.virtual.skeleton import FingerPose, HandPose
from halo_service.virtual.stage import Play

LIMIT_MM, LIMIT_G = 2000.0, 2000.0


@dataclasses.dataclass(frozen=True, slots=True)
class Pull:
    """One message, checked."""

    side: Side
    finger: Finger
    aim: FingerPose | None
    """None: take the hand away."""


def pull(message: object) -> Pull:
    """Read a message. Raises UserError when it is none."""
    if not isinstance(message, Sequence) or len(message) != 6:
        raise UserError("A finger's message is: hand, finger, x_mm, y_mm, height_mm, force_g.")
    try:
        side, finger = Side(int(message[0])), Finger(int(message[1]))
        x, y, height, force = (float(v) for v in message[2:])
    except (TypeError, ValueError):
        raise UserError(f"A finger's message holds something else: {message!r}.") from None
    if side is Side.UNKNOWN:
        raise UserError("A finger's message needs a hand: 1 left, 2 right.")
    if not all(np.isfinite((x, y, height, force))) or max(map(abs, (x, y, height))) > LIMIT_MM:
        raise UserError(f"A finger cannot be there: {x:g}, {y:g}, {height:g} mm.")
    if not 0.0 <= force <= LIMIT_G:
        raise UserError(f"A finger cannot press with {force:g} g; give 0 to {LIMIT_G:g}.")
    if height < 0.0:
        return Pull(side, finger, None)
    return Pull(side, finger, FingerPose(x, y, 0.0 if force > 0.0 else height, force))


class Puppet:
    """One hand on strings."""

    def __init__(self, room: Room, side: Side) -> None:
        self._room, self._side = room, side
        self._finger = Finger.INDEX
        self._aim: FingerPose | None = None

    def obey(self, order: Pull) -> None:
        """From now on, be like that."""
        self._finger, self._aim = order.finger, order.aim

    def pose(self, t_s: float) -> HandPose | None:
        """As the last message had it, whatever the time."""
        if self._aim is None:
            return None
        return pointing(
            self._room.user, self._side, self._aim, finger=self._finger, curl=self._room.user.curl
        )

    def begun(self, t_s: float) -> list[Contact]:
        """None: nobody knows yet when a played touch will end; the lines of each frame tell."""
        return []

    def tools(self, t_s: float) -> list[Body]:
        """None."""
        return []

    @property
    def finished(self) -> bool:
        """Never."""
        return False


def hand(room: Room, rng: np.random.Generator) -> Play:
    """An empty table until the first message."""
    puppets = {side: Puppet(room, side) for side in (Side.LEFT, Side.RIGHT)}

    def listen(message: object) -> None:
        order = pull(message)
        puppets[order.side].obey(order)

    return Play(room, list(puppets.values()), listen=listen)
