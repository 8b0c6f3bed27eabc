"""Handles the messages that clients send to the control port.

Rule: one row per address. An unknown or wrong message is logged once and skipped.
"""

from __future__ import annotations

import logging
import time
from collections.abc import Callable

from halo_protocol.handshake import GOODBYE, HELLO, LEASE
from halo_service.app.service.profile_reloader import ProfileReloader
from halo_service.errors import UserError
from halo_service.outputs.control import ControlMessage, ControlPort
from halo_service.outputs.leases import Leases
from halo_service.outputs.osc import OscOutput
from halo_service.sensing import State
from halo_service.sources import Source

log = logging.getLogger(__name__)

MAX_WARNINGS = 64
"""Different warnings that are logged, each once; any client can send more."""


class ControlHandler:
    """Handles what has arrived since the last frame."""

    def __init__(
        self,
        control: ControlPort,
        reloader: ProfileReloader,
        leases: Leases | None = None,
        osc: OscOutput | None = None,
    ) -> None:
        """`leases`, `osc`: clients that ask for the stream, and what sends to them."""
        self._control = control
        self._leases, self._osc = leases, osc
        self._reloader = reloader
        self._warned: set[str] = set()
        self._rows: dict[str, Callable[[ControlMessage, State, Source | None], State]] = {
            "/halo/1/sim/finger": _move_finger,
            "/halo/1/control/background": self._retake_background,
        }
        if leases is not None:
            self._rows |= dict.fromkeys((HELLO, LEASE, GOODBYE), self._stream)

    def handle(self, state: State, source: Source | None) -> State:
        """Handle all messages; return the new state. `source`: None while it is lost."""
        for message in self._control.drain():
            row = self._rows.get(message.address)
            try:
                if row is None:
                    raise UserError(f"unknown address; choose from: {', '.join(self._rows)}")
                state = row(message, state, source)
            except UserError as error:
                self._warn(message, str(error))
        if self._leases is not None and self._osc is not None:
            self._leases.expire(time.monotonic())
            self._osc.set_leased(self._leases.destinations)
        return self._reloader.refresh(state)

    def _stream(self, message: ControlMessage, state: State, source: Source | None) -> State:
        """Answer a client that asks for the stream, or renews or ends it."""
        del source
        assert self._leases is not None  # else the address is unknown
        for datagram, to in self._leases.handle(message, time.monotonic()):
            self._control.reply(datagram, to)
        return state

    def _retake_background(
        self, message: ControlMessage, state: State, source: Source | None
    ) -> State:
        """Start a new background; the revision in the scene changes when it is done."""
        del message, source
        self._reloader.retake_background()
        return state

    def _warn(self, message: ControlMessage, why: str) -> None:
        warning = f"control: skipped {message.address[:80]}: {why}"
        if warning not in self._warned and len(self._warned) < MAX_WARNINGS:
            self._warned.add(warning)
            log.warning("%s", warning)


def _move_finger(message: ControlMessage, state: State, source: Source | None) -> State:
    """Move the finger of the virtual camera `sim:hand`."""
    from halo_service.virtual.live import VirtualKinect
    from halo_service.virtual.scenarios.controlled import parse_command

    if not isinstance(source, VirtualKinect):
        raise UserError("the source is no virtual camera; start with --source sim:hand")
    parse_command(message.arguments)  # raises `UserError` with the reason for a wrong message
    source.tell(message.arguments)
    return state
