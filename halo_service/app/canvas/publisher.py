"""Sends the canvas as a service sends its surface, and once more for each further projector."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import replace

from halo_service.app.service.carriers import Carriers
from halo_service.app.versions import service_version
from halo_service.canvas import reports
from halo_service.canvas.layout import Layout
from halo_service.canvas.reports import CanvasStatus, NodeReports
from halo_service.host_clock import CLOCK
from halo_service.outputs import Carrier
from halo_service.outputs.frame_encoder import FrameEncoder
from halo_service.outputs.name_watch import NameWatch
from halo_service.outputs.outgoing import Outgoing, OutgoingReport, Reported
from halo_service.values import TouchFrame


class CanvasPublisher:
    """Sends frames and reports on all carriers; used by one thread at a time."""

    def __init__(
        self,
        layout: Layout,
        frames: FrameEncoder,
        carriers: Sequence[Carrier],
        names: NameWatch,
        control_port: int,
        zenoh_missing: Callable[[], int],
        zenoh_version: str = "",
    ) -> None:
        """`zenoh_missing`: counts the endpoints without a connection; `zenoh_version`: empty
        without Zenoh."""
        self._layout = layout
        self._frames = frames
        self._carriers = Carriers(carriers)
        self._names = names
        self._control_port = control_port
        self.zenoh_missing = zenoh_missing
        self._zenoh_version = zenoh_version
        self.rate_hz = 0.0
        """Of the last scene; 0 while it is unknown."""
        # Now, because OpenCV is imported for it, which takes half a second.
        self._projectors = [(each, each.matrix) for each in layout.projector]
        self._copies = [layout.surface_name(each) for each in layout.projector if each.name]

    @property
    def node(self) -> str:
        """Name of the canvas."""
        return self._frames.node

    @property
    def session(self) -> str:
        """Name of this run."""
        return self._frames.session

    def frame(self, frame: TouchFrame) -> None:
        """Send one frame."""
        self._send_all(self._frames.encode(frame))

    def scene(self, status: CanvasStatus, nodes: Sequence[NodeReports], rate_hz: float) -> None:
        """Send the scene and the homographies."""
        collision = self._names.collision(time.monotonic())
        scene = reports.scene(status, self._layout, nodes, rate_hz, self._control_port, collision)
        self.rate_hz = scene.rate_hz
        self._report_all(
            replace(scene, service_version=service_version(), zenoh_version=self._zenoh_version)
        )
        for projector, matrix in self._projectors:  # after the scene: they refer to its revision
            surface = self._layout.surface_name(projector)
            message = reports.homography(status, projector, matrix)
            outgoing = OutgoingReport(surface, message, named_only=bool(projector.name))
            self._carriers.send(outgoing)

    def health(self, status: CanvasStatus, nodes: Sequence[NodeReports]) -> None:
        """Send the health."""
        _, error_ms = CLOCK.check()
        time_s, time_frac_us = divmod(CLOCK.unix_us(), 1_000_000)
        self._report_all(
            replace(
                reports.health(status, nodes),
                clock_error_ms=error_ms,
                time_s=time_s,
                time_frac_us=time_frac_us,
            )
        )

    def _report_all(self, message: Reported) -> None:
        self._send_all(OutgoingReport(self._layout.name, message))

    def _send_all(self, outgoing: Outgoing) -> None:
        """Send on the canvas's surface, then for each projector that has one of its own."""
        self._carriers.send(outgoing)
        for surface in self._copies:
            self._carriers.send(replace(outgoing, surface=surface, named_only=True))
