"""`hand`: a finger that messages control, one message for each move.

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
from halo_service.virtual.scenario import Scenario
from halo_service.virtual.skeleton import FingerPose, HandPose

LIMIT_MM, LIMIT_G = 2000.0, 2000.0


@dataclasses.dataclass(frozen=True, slots=True)
class FingerCommand:
    """One message, checked."""

    side: Side
    finger: Finger
    aim: FingerPose | None
    """None: take the hand out of view."""


def parse_command(message: object) -> FingerCommand:
    """Read a message. Raises UserError for one that is not valid."""
    if not isinstance(message, Sequence) or len(message) != 6:
        raise UserError(
            "A finger message needs 6 values: hand, finger, x_mm, y_mm, height_mm, force_g."
        )
    try:
        side, finger = Side(int(message[0])), Finger(int(message[1]))
        x, y, height, force = (float(v) for v in message[2:])
    except (TypeError, ValueError):
        raise UserError(f"A finger message needs six numbers, not {message!r}.") from None
    if side is Side.UNKNOWN:
        raise UserError("A finger message needs a hand: 1 left or 2 right.")
    if not all(np.isfinite((x, y, height, force))) or max(map(abs, (x, y, height))) > LIMIT_MM:
        raise UserError(f"A finger cannot be there: {x:g}, {y:g}, {height:g} mm.")
    if not 0.0 <= force <= LIMIT_G:
        raise UserError(f"A finger cannot press with {force:g} g; give 0 to {LIMIT_G:g}.")
    if height < 0.0:
        return FingerCommand(side, finger, None)
    return FingerCommand(side, finger, FingerPose(x, y, 0.0 if force > 0.0 else height, force))


class ControlledHand:
    """One hand that follows messages."""

    def __init__(self, room: Room, side: Side) -> None:
        self._room, self._side = room, side
        self._finger = Finger.INDEX
        self._aim: FingerPose | None = None

    def set(self, command: FingerCommand) -> None:
        """Use this finger and aim from now on."""
        self._finger, self._aim = command.finger, command.aim

    def pose(self, t_s: float) -> HandPose | None:
        """The pose of the last message, at any time."""
        if self._aim is None:
            return None
        aim = dataclasses.replace(self._aim, yaw_deg=self._room.seat_deg)
        user = self._room.user
        return pointing(user, self._side, aim, finger=self._finger, curl=user.curl)

    def started_contacts(self, t_s: float) -> list[Contact]:
        """None: the end of a touch is not known yet; the line of each frame has its state."""
        return []

    def tools(self, t_s: float) -> list[Body]:
        """No objects."""
        return []

    @property
    def finished(self) -> bool:
        """Never."""
        return False


def hand(room: Room, rng: np.random.Generator) -> Scenario:
    """An empty table until the first message."""
    hands = {side: ControlledHand(room, side) for side in (Side.LEFT, Side.RIGHT)}

    def on_message(message: object) -> None:
        command = parse_command(message)
        hands[command.side].set(command)

    return Scenario(room, list(hands.values()), on_message=on_message)
