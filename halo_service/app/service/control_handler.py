"""Handles the messages that clients send to the control port or by WebSocket.

Rule: one row per address; only hosts in the allowed networks are heard. An unknown or wrong
message is logged once and skipped.
"""

from __future__ import annotations

import logging
import threading
import time
from collections.abc import Callable
from dataclasses import replace

import halo_protocol as wire
from halo_protocol.handshake import CONTROL, GOODBYE, HELLO, LEASE
from halo_service.app.service.commands import (
    LEAST_STATUS,
    STATUS,
    Status,
    is_press,
    profile_folder,
    with_setting,
)
from halo_service.app.service.control_nodes import control_nodes
from halo_service.app.service.profile_reloader import ProfileReloader
from halo_service.errors import UserError
from halo_service.outputs.control import ControlMessage, ControlPort
from halo_service.outputs.leases import Leases
from halo_service.outputs.osc import OscOutput
from halo_service.sensing import SensingSettings, State
from halo_service.sources import Source
from halo_service.web.oscquery import Node

log = logging.getLogger(__name__)

MAX_WARNINGS = 64
"""Different warnings that are logged, each once; any client can send more."""
SENSING = f"{CONTROL}sensing/"
"""Addresses of the settings of `[sensing]`."""

Row = Callable[[ControlMessage, State, Source | None], State]


class ControlHandler:
    """Handles what has arrived since the last frame."""

    def __init__(
        self,
        control: ControlPort,
        reloader: ProfileReloader,
        leases: Leases,
        osc: OscOutput,
        paused: threading.Event,
    ) -> None:
        """`leases`, `osc`: clients that ask for the stream, and what sends to them; `paused`: set
        while frames are to have no pointers."""
        self._control = control
        self._leases, self._osc = leases, osc
        self._reloader = reloader
        self._paused = paused
        self._settings = SensingSettings()
        self._virtual = False
        self._error = ""
        """Why the last command failed; empty: it did not."""
        self._warned: set[str] = set()
        self._triggers: dict[str, Callable[[], None]] = {
            f"{CONTROL}pause": self._pause,
            f"{CONTROL}resume": self._resume,
            f"{CONTROL}background": reloader.retake_background,
        }
        self._rows: dict[str, Row] = {
            "/halo/1/sim/finger": _move_finger,
            **dict.fromkeys(self._triggers, self._trigger),
            f"{CONTROL}profile": self._switch_profile,
            STATUS: self._answer_status,
            **dict.fromkeys((HELLO, LEASE, GOODBYE), self._stream),
        }

    def handle(self, state: State, source: Source | None) -> State:
        """Handle all messages; return the new state. `source`: None while it is lost."""
        for message in self._control.drain():
            if not self._leases.networks.allow(message.sender[0]):
                self._warn(message, "its host is not in [control] networks")
                continue
            try:
                state = self._row(message.address)(message, state, source)
            except UserError as error:
                self._error = str(error)
                self._warn(message, str(error))
        self._leases.expire(time.monotonic())
        self._osc.set_leased(self._leases.destinations)
        self._settings = state.settings
        self._virtual = source is not None and source.kind == "virtual"
        return self._reloader.refresh(state)

    def nodes(self) -> list[Node]:
        """Return what clients can send, for OSCQuery; from any thread."""
        nodes = control_nodes(
            self._settings, self._profile_name(), self._status(), virtual=self._virtual
        )
        return list(nodes)

    def _row(self, address: str) -> Row:
        if address.startswith(SENSING):
            return self._set
        if address not in self._rows:
            raise UserError(f"unknown address; choose from: {', '.join(self._rows)}, {SENSING}...")
        return self._rows[address]

    def _stream(self, message: ControlMessage, state: State, source: Source | None) -> State:
        """Answer a client that asks for the stream, or renews or ends it."""
        del source
        for datagram, _ in self._leases.handle(message, time.monotonic()):
            message.answer(datagram)
        return state

    def _trigger(self, message: ControlMessage, state: State, source: Source | None) -> State:
        del source
        if is_press(message.arguments):
            self._error = ""
            self._triggers[message.address]()
        return state

    def _pause(self) -> None:
        if not self._paused.is_set():
            log.info("paused: frames have no pointers until a client resumes")
        self._paused.set()

    def _resume(self) -> None:
        if self._paused.is_set():
            log.info("resumed")
        self._paused.clear()

    def _switch_profile(
        self, message: ControlMessage, state: State, source: Source | None
    ) -> State:
        del source
        self._error = ""
        self._reloader.switch(profile_folder(message.arguments))
        return state

    def _set(self, message: ControlMessage, state: State, source: Source | None) -> State:
        """Change a setting of `[sensing]` until the service ends; the settings file stays."""
        del source
        self._error = ""
        name = message.address.removeprefix(SENSING)
        return replace(state, settings=with_setting(state.settings, name, message.arguments))

    def _answer_status(self, message: ControlMessage, state: State, source: Source | None) -> State:
        del source
        if message.size < LEAST_STATUS:
            raise UserError(f"fill it up with text to {LEAST_STATUS} bytes, for its answer is long")
        if not is_press(message.arguments):
            return state
        message.answer(self._status().packed())
        return state

    def _status(self) -> Status:
        return Status(
            self._leases.node,
            self._leases.session,
            wire.VERSION,
            self._profile_name(),
            self._error or self._reloader.error,
            int(self._paused.is_set()),
        )

    def _profile_name(self) -> str:
        profile = self._reloader.profile
        return profile.name if profile else ""

    def _warn(self, message: ControlMessage, why: str) -> None:
        text = f"control: skipped {message.address[:80]}: {why}"
        # A client's text must not begin new lines in the log.
        warning = "".join(each if each.isprintable() else "?" for each in text)
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
    source.command(message.arguments)
    return state
