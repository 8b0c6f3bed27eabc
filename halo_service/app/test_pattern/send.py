"""Sends the test pattern as a service without a camera: same outputs, same messages."""

from __future__ import annotations

import logging
import time
from collections.abc import Sequence
from contextlib import ExitStack, closing
from dataclasses import dataclass

import halo_protocol as wire
from halo_service.app.service.carriers import frame_encoder, zenoh_output
from halo_service.app.service.client_ports import ClientPorts
from halo_service.app.versions import service_version, zenoh_version
from halo_service.host_clock import CLOCK
from halo_service.outputs import Carrier
from halo_service.outputs.destination import Destination
from halo_service.outputs.frame_encoder import FrameEncoder
from halo_service.outputs.osc import OscOutput
from halo_service.outputs.outgoing import OutgoingReport
from halo_service.outputs.test_pattern import Pattern
from halo_service.settings import Settings
from halo_service.values import TouchFrame

log = logging.getLogger(__name__)

RATE_HZ = 30.0
SCENE_S, HEALTH_S = 0.5, 1.0


def send_pattern(settings: Settings, only: Sequence[Destination], seconds: float | None) -> None:
    """Send until Ctrl-C or for some seconds, on every output of the settings.

    `only`: send to these alone; empty: on every output.
    """
    with ExitStack() as stack:
        ports = ClientPorts(settings, settings.node, stack, only)
        osc = stack.enter_context(closing(OscOutput(ports.destinations)))
        zenoh = zenoh_output(settings, ports.names, Pattern().surface, stack) if not only else []
        ports.log()
        log.info("ready: a pointer draws a circle every 4 s; Ctrl-C ends")
        sender = PatternSender(
            Pattern(),
            frame_encoder(settings, ports.session),
            [osc, *zenoh, *ports.carriers],
            ports.control.port,
            zenoh_version() if zenoh else "",
        )
        until_s = time.monotonic() + seconds if seconds is not None else None
        for leased in ports.turns(1.0 / RATE_HZ):
            osc.set_leased(leased)
            sender.send(time.monotonic())
            if until_s is not None and time.monotonic() >= until_s:
                break
        sender.end()


@dataclass(frozen=True, slots=True)
class _Due:
    scene_s: float = float("-inf")
    health_s: float = float("-inf")
    frame_s: float = -1.0


class PatternSender:
    """Encodes the pattern and its reports for carriers; time is an argument."""

    def __init__(
        self,
        pattern: Pattern,
        frames: FrameEncoder,
        carriers: Sequence[Carrier],
        control_port: int = 0,
        zenoh_version: str = "",
    ) -> None:
        """`control_port`: 0 if there is none; `zenoh_version`: empty without Zenoh."""
        self._pattern, self._frames, self._carriers = pattern, frames, carriers
        self._control_port = control_port
        self._zenoh_version = zenoh_version
        self._began_s: float | None = None
        self._due = _Due()

    def send(self, now_s: float) -> None:
        """Send the frame of a time, and the reports that are due; `now_s`: monotonic."""
        if self._began_s is None:
            self._began_s = now_s
        scene_s, health_s = self._due.scene_s, self._due.health_s
        if now_s - scene_s >= SCENE_S:
            scene_s = now_s
            self._report(self._scene())
        if now_s - health_s >= HEALTH_S:
            health_s = now_s
            self._report(self._health())
        t_s = now_s - self._began_s
        frame = self._pattern.frame(t_s, self._due.frame_s, CLOCK.unix_us())
        self._due = _Due(scene_s, health_s, t_s)
        self._send(frame)

    def end(self) -> None:
        """Send an empty frame, so that no pointer stays at a client."""
        pattern = self._pattern
        size_mm = pattern.width_mm, pattern.height_mm
        self._send(TouchFrame(CLOCK.unix_us(), pattern.surface, *size_mm))

    def _send(self, frame: TouchFrame) -> None:
        outgoing = self._frames.encode(frame)
        for carrier in self._carriers:
            carrier.send(outgoing)

    def _report(self, message: wire.Scene | wire.Health) -> None:
        for carrier in self._carriers:
            carrier.send(OutgoingReport(self._pattern.surface, message))

    def _scene(self) -> wire.Scene:
        return wire.Scene(
            self._frames.node,
            self._frames.session,
            wire.VERSION,
            self._pattern.width_mm,
            self._pattern.height_mm,
            wire.Calibration.COMPLETE,
            1,
            wire.Source.VIRTUAL,
            RATE_HZ,
            self._control_port,
            service_version=service_version(),
            zenoh_version=self._zenoh_version,
        )

    def _health(self) -> wire.Health:
        time_s, time_frac_us = divmod(CLOCK.unix_us(), 1_000_000)
        return wire.Health(
            self._frames.node,
            self._frames.session,
            RATE_HZ,
            0.0,
            0,
            0,
            wire.Tracker.OFF,
            wire.Camera.RUNNING,
            -1.0,
            time_s=time_s,
            time_frac_us=time_frac_us,
        )
