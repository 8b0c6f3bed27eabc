"""What a client receives, and what must not be in it: gaps, and touches that stay."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

from halo_protocol import Health, Lost, Report, Scene, TouchFrame

STUCK_S = 1.5
"""A tap lasts 0.2 s; a pointer that touches for longer is stuck."""
GAP_S = 1.1
"""A client gets a frame at least once a second."""


@dataclass
class Seen:
    """What the client received."""

    frames: int = 0
    gaps: int = 0
    longest_gap_s: float = 0.0
    downs: int = 0
    stuck: set[tuple[str, int]] = field(default_factory=set)
    sessions: set[str] = field(default_factory=set)
    last_frame_s: float | None = None
    down_s: float = 0.0
    """When the last touch began."""
    health: Health | None = None
    scene: Scene | None = None
    open: dict[tuple[str, int, int], float] = field(default_factory=dict)
    """Touches that go on, and since when."""

    def update(self, event: Any, now_s: float) -> None:
        """Count one event."""
        if isinstance(event, Report):
            message = event.message
            self.health = message if isinstance(message, Health) else self.health
            self.scene = message if isinstance(message, Scene) else self.scene
        elif isinstance(event, Lost):
            self.open = {key: at for key, at in self.open.items() if key[0] != event.session}
            self.last_frame_s = None  # the frame before it was made by the client
        elif isinstance(event, TouchFrame):
            self._frame(event, now_s)

    def _frame(self, frame: TouchFrame, now_s: float) -> None:
        if self.last_frame_s is not None:
            gap_s = now_s - self.last_frame_s
            self.longest_gap_s = max(self.longest_gap_s, gap_s)
            self.gaps += gap_s > GAP_S
        self.last_frame_s = now_s
        self.frames += 1
        self.sessions.add(frame.session)
        if frame.downs:
            self.downs += len(frame.downs)
            self.down_s = now_s
        touching = {(frame.session, p.id, p.contacts) for p in frame.pointers if p.touching}
        self.open = {key: self.open.get(key, now_s) for key in touching}
        self.stuck |= {key[:2] for key, at in self.open.items() if now_s - at > STUCK_S}
