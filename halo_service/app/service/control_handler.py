"""What clients say to the control port, and what becomes of it.

Rule: one row an address. What nobody understands is told once and skipped.
"""

from __future__ import annotations

import logging
from collections.abc import Callable

from halo_service.app.service.profile_reloader import ProfileReloader
from halo_service.errors import UserError
from halo_service.outputs.control import ControlMessage, ControlPort
from halo_service.sensing import State
from halo_service.sources import Source

log = logging.getLogger(__name__)

REMEMBERED = 64
"""Complaints kept, so that each is made once."""


class ControlHandler:
    """Takes what has come since the last frame, and obeys."""

    def __init__(self, control: ControlPort, keeper: ProfileReloader) -> None:
        self._control = control
        self._keeper = keeper
        self._complained: set[str] = set()
        self._rows: dict[str, Callable[[ControlMessage, State, Source | None], State]] = {
            "/halo/1/sim/finger": _play_finger,
            "/halo/1/control/background": self._retake,
        }

    def obey(self, state: State, source: Source | None) -> State:
        """Obey all orders; return the state that they leave. `source`: None while it is lost."""
        for told in self._control.drain():
            row = self._rows.get(told.address)
            try:
                if row is None:
                    raise UserError(f"nobody understands it; known: {', '.join(self._rows)}")
                state = row(told, state, source)
            except UserError as error:
                self._complain(told, str(error))
        return self._keeper.refresh(state)

    def _retake(self, told: ControlMessage, state: State, source: Source | None) -> State:
        """Take the background anew; the scene's revision tells when it is there."""
        del told, source
        self._keeper.retake()
        return state

    def _complain(self, told: ControlMessage, why: str) -> None:
        said = f"control: {told.address[:80]} was skipped: {why}"
        if said not in self._complained and len(self._complained) < REMEMBERED:
            self._complained.add(said)
            log.warning("%s", said)


def _play_finger(told: ControlMessage, state: State, source: Source | None) -> State:
    """Hand a finger's place to the virtual Kinect that is played by messages."""
    from halo_service.virtual.live import VirtualKinect
    from halo_service.virtual.scenarios.controlled import parse_command

    if not isinstance(source, VirtualKinect):
        raise UserError("there is no virtual Kinect to play; start with --source sim:hand")
    parse_command(
        told.arguments
    )  # a message that holds something else is refused here, with its reason
    source.tell(told.arguments)
    return state
