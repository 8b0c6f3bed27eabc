"""One surface from those of several nodes.

Rule: pure; times are arguments. Frames of nodes go in with their time of arrival, frames of the
canvas come out:

    arrival, time of sending -> clock -> time here \\
    pointers, events -> layout -> place here -------> fusion -> pace: now? -> frame of the canvas
"""

from __future__ import annotations

from dataclasses import dataclass, field

import halo_protocol as wire
from halo_service.canvas.clocks import Clock
from halo_service.canvas.detections import Area, SurfaceKey
from halo_service.canvas.fusion import Fusion, NodeFrame
from halo_service.canvas.layout import Layout
from halo_service.canvas.pace import Pace
from halo_service.values import TouchFrame


@dataclass(slots=True)
class Node:
    """What is known of one surface of the layout."""

    area: Area
    session: str = ""
    """Empty while it is not there."""
    clock: Clock = field(default_factory=Clock)
    time_us: int = 0
    """Of its last frame, on the canvas's clock."""
    frames: int = 0
    missed: int = 0
    incomplete: int = 0
    """Frames that arrived, never arrived, and arrived in part, since the canvas started."""


class Canvas:
    """Merges frames of nodes."""

    def __init__(self, layout: Layout) -> None:
        self._layout = layout
        areas = {area.surface: area for area in map(Area, layout.surface)}
        self.nodes = {surface: Node(area) for surface, area in areas.items()}
        self.pace = Pace()
        self._fusion = Fusion(areas)
        self._time_us = 0
        self._lag_us = 0

    def handle(self, surface: SurfaceKey, event: wire.Event, now_us: int) -> TouchFrame | None:
        """Note what arrived of a node; return the canvas's frame if it is time to send one."""
        if isinstance(event, wire.TouchFrame):
            return self.arrived(event, now_us)
        if isinstance(event, wire.Report) and isinstance(event.message, wire.Scene):
            self.scene(surface, event.message)
        elif isinstance(event, wire.Report) and isinstance(event.message, wire.Health):
            self.health(surface, event.message)
        elif isinstance(event, wire.Lost) and self.is_session(surface, event.session):
            return self.lost(surface, now_us)
        return None

    def is_session(self, surface: SurfaceKey, session: str) -> bool:
        """Whether a session is the one that is there now; a newer one may have begun."""
        return surface in self.nodes and self.nodes[surface].session == session

    def scene(self, surface: SurfaceKey, scene: wire.Scene) -> None:
        """Note the size of a node's surface."""
        if surface in self.nodes and scene.width_mm > 0.0 and scene.height_mm > 0.0:
            self.nodes[surface].area.size_mm = (scene.width_mm, scene.height_mm)

    def health(self, surface: SurfaceKey, health: wire.Health) -> None:
        """Note what a node needs from exposure to sending."""
        if surface in self.nodes and health.latency_ms >= 0.0:
            self.nodes[surface].clock.latency_us = health.latency_ms * 1000.0

    def arrived(self, frame: wire.TouchFrame, arrival_us: int) -> TouchFrame | None:
        """Note a node's frame; return the canvas's frame if it is time to send one."""
        surface = (frame.node, frame.surface)
        if surface not in self.nodes:
            return None
        node = self.nodes[surface]
        if node.session != frame.session:
            self._forget(surface, arrival_us)
            node.session = frame.session
        node.frames += 1
        node.missed += frame.missed
        node.incomplete += not frame.complete
        node.time_us = max(node.clock.arrived(frame.time_us, arrival_us), node.time_us + 1)
        self._guess_size(node.area, frame)
        self._fusion.receive(_on_canvas(node, frame))
        due = self.pace.arrived(surface, arrival_us, len(frame.pointers))
        return self.frame(arrival_us) if due or self._fusion.has_news else None

    def lost(self, surface: SurfaceKey, now_us: int) -> TouchFrame | None:
        """Forget what a node reported: it is silent, or has ended."""
        if surface not in self.nodes or not self.nodes[surface].session:
            return None
        self._forget(surface, now_us)
        return self.frame(now_us)

    def tick(self, now_us: int) -> TouchFrame | None:
        """Return a frame where none was sent for long."""
        return self.frame(now_us) if self.pace.is_idle(now_us) else None

    def _forget(self, surface: SurfaceKey, now_us: int) -> None:
        """End a session; the next one starts with a clock of its own."""
        node = self.nodes[surface]
        self._fusion.lose(surface, max(self._time_us, now_us - self._lag_us))
        self.pace.lose(surface)
        node.session, node.clock, node.time_us = "", Clock(node.clock.latency_us), 0

    def frame(self, now_us: int) -> TouchFrame:
        """Return a frame of what is there now."""
        newest_us = max(each.time_us for each in self.nodes.values())
        if self.pace.is_idle(now_us):
            newest_us = max(newest_us, now_us - self._lag_us)
        self._time_us = max(self._time_us + 1, newest_us)
        self._lag_us = now_us - self._time_us
        self.pace.sent(now_us)
        pointers, events = self._fusion.frame(self._time_us)
        layout = self._layout
        return TouchFrame(
            self._time_us, layout.name, layout.width_mm, layout.height_mm, pointers, events
        )

    @staticmethod
    def _guess_size(area: Area, frame: wire.TouchFrame) -> None:
        """Compute the size from a pointer, until the scene arrives."""
        if area.size_mm is not None:
            return
        for each in frame.pointers:
            if each.u > 0.0 and each.v > 0.0 and each.x_mm > 0.0 and each.y_mm > 0.0:
                area.size_mm = (each.x_mm / each.u, each.y_mm / each.v)
                return


def _on_canvas(node: Node, frame: wire.TouchFrame) -> NodeFrame:
    area, time_us = node.area, node.time_us
    return NodeFrame(
        area.surface,
        time_us,
        tuple(area.detection(each, time_us) for each in frame.pointers),
        tuple(
            ((area.surface, each.id), each, area.event(each, time_us))
            for each in frame.events[: wire.MAX_EVENTS]
        ),
    )
