"""Hands what threads receive of nodes to the canvas, and what it returns to the publisher.

Rule: one lock around the canvas and its outputs, so that frames leave in their order. No frame
waits in a queue: the thread that received it also sends.
"""

from __future__ import annotations

import logging
import statistics
import threading
from collections import deque
from collections.abc import Sequence

import halo_protocol as wire
from halo_service.app.canvas.publisher import CanvasPublisher
from halo_service.app.following import received_events
from halo_service.canvas.canvas import Canvas
from halo_service.canvas.detections import SurfaceKey
from halo_service.canvas.layout import Layout
from halo_service.canvas.placement import placement_warnings
from halo_service.canvas.reports import CanvasStatus, NodeReports, clock_sentence
from halo_service.host_clock import CLOCK
from halo_service.runtime.memory import memory_mb
from halo_service.values import TouchFrame

log = logging.getLogger(__name__)

SCENE_US, HEALTH_US = 500_000, 1_000_000
CLOCKS_US = 60_000_000
"""How often the clocks of the nodes are logged, and first after a sixth of it."""
COPIES = 3
"""Last frames, without pointers: each carries the last `up`."""


class Merger:
    """The canvas, shared by the threads that follow its nodes."""

    def __init__(self, layout: Layout, publisher: CanvasPublisher) -> None:
        self._lock = threading.Lock()
        self._layout = layout
        self._canvas = Canvas(layout)
        self._publisher = publisher
        self._reports = dict.fromkeys(self._canvas.nodes, NodeReports())
        self._latency_ms: deque[float] = deque(maxlen=wire.MAX_EVENTS)
        self._sent_us: deque[int] = deque(maxlen=wire.MAX_EVENTS)
        self._scene_us = self._health_us = 0
        self._clocks_us: int | None = None
        self._placement_checked = False
        self.ends = False
        """Set before the nodes are closed, so that they are not logged as lost."""

    def handle(self, surface: SurfaceKey, events: Sequence[wire.Event]) -> None:
        """Note what arrived of one node; from any thread."""
        if not events:
            return
        with self._lock:
            for event in received_events(events):
                if isinstance(event, wire.Lost):
                    self._note_lost(surface, event.session)
                self._send(self._canvas.handle(surface, event, CLOCK.unix_us()))
                if isinstance(event, wire.Report):
                    self._note(surface, event.message)

    def turn(self) -> None:
        """Send what is due; a few times a second."""
        with self._lock:
            now_us = CLOCK.unix_us()
            self._send(self._canvas.tick(now_us))
            if now_us - self._scene_us >= SCENE_US:
                self._scene_us = now_us
                self._send_scene()
            if now_us - self._health_us >= HEALTH_US:
                self._health_us = now_us
                self._publisher.health(self._canvas_status(), list(self._reports.values()))
            if self._clocks_us is None:
                self._clocks_us = now_us - CLOCKS_US * 5 // 6
            if now_us - self._clocks_us >= CLOCKS_US:
                self._clocks_us = now_us
                self._log_clocks()

    def welcome(self) -> None:
        """Send the reports, for a client that is new."""
        with self._lock:
            self._send_scene()

    def end(self) -> None:
        """Send frames without pointers, so that none stays at a client."""
        with self._lock:
            for surface in self._canvas.nodes:
                self._send(self._canvas.lost(surface, CLOCK.unix_us()))
            for _ in range(COPIES):
                self._send(self._canvas.frame(CLOCK.unix_us()))

    def summary(self) -> list[str]:
        """Return a sentence for each node: what arrived of it, and what was lost."""
        with self._lock:
            return [
                f"{'/'.join(surface)}: {node.frames} frames arrived, {node.missed} missed, "
                f"{node.incomplete} incomplete"
                for surface, node in self._canvas.nodes.items()
            ]

    def _note(
        self, surface: SurfaceKey, message: wire.Scene | wire.Homography | wire.Pose | wire.Health
    ) -> None:
        known = self._reports[surface]
        if isinstance(message, wire.Scene):
            if known.scene is None:
                log.info(
                    "%s is there: %.0f x %.0f mm",
                    "/".join(surface),
                    message.width_mm,
                    message.height_mm,
                )
            self._reports[surface] = NodeReports(message, known.health)
            self._check_placement()
        elif isinstance(message, wire.Health):
            self._reports[surface] = NodeReports(known.scene, message)

    def _check_placement(self) -> None:
        """Warn once, when the sizes of all surfaces are known."""
        areas = [each.area for each in self._canvas.nodes.values()]
        if self._placement_checked or not all(each.size_mm for each in areas):
            return
        self._placement_checked = True
        for warning in placement_warnings(self._layout, areas):
            log.warning("%s", warning)

    def _note_lost(self, surface: SurfaceKey, session: str) -> None:
        """Forget the reports of a node, unless a newer session of it has begun."""
        if self._canvas.is_session(surface, session):
            if self._reports[surface].scene is not None and not self.ends:
                log.info("%s is lost; its touches are ended", "/".join(surface))
            self._reports[surface] = NodeReports()

    def _send(self, frame: TouchFrame | None) -> None:
        if frame is None:
            return
        self._publisher.frame(frame)
        now_us = CLOCK.unix_us()
        self._sent_us.append(now_us)
        self._latency_ms.append((now_us - frame.time_us) / 1000.0)

    def _send_scene(self) -> None:
        nodes = list(self._reports.values())
        self._publisher.scene(self._canvas_status(), nodes, self._canvas.pace.rate_hz)

    def _canvas_status(self) -> CanvasStatus:
        nodes = self._canvas.nodes.values()
        there = [each.clock for each in nodes if each.session and each.clock.fit is not None]
        worst = max(there, key=lambda each: abs(each.behind_us), default=None)
        newest_us = self._sent_us[-1] if self._sent_us else 0
        recent = [each for each in self._sent_us if newest_us - each <= HEALTH_US]
        span_s = (newest_us - recent[0]) / 1e6 if recent else 0.0
        return CanvasStatus(
            self._publisher.node,
            self._publisher.session,
            fps=(len(recent) - 1) / span_s if span_s > 0.0 else 0.0,
            latency_ms=statistics.median(self._latency_ms) if there else -1.0,
            missed=sum(each.missed for each in nodes),
            incomplete=sum(each.incomplete for each in nodes),
            restarts=sum(each.clock.restarts for each in nodes),
            memory_mb=memory_mb(),
            zenoh_missing=self._publisher.zenoh_missing(),
            nodes=len(there),
            clock_offset_ms=worst.behind_us / 1000.0 if worst else 0.0,
            clock_deviation_ms=worst.fit.deviation_us / 1000.0 if worst and worst.fit else -1.0,
        )

    def _log_clocks(self) -> None:
        for surface, node in self._canvas.nodes.items():
            if node.clock.fit is not None:
                behind_ms = node.clock.behind_us / 1000.0
                log.info("%s", clock_sentence(surface, node.clock.fit, behind_ms))
