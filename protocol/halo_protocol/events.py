"""Events that an assembler reports to a client.

Rule: values only.
"""

from __future__ import annotations

from dataclasses import dataclass

from halo_protocol.messages import Down, Health, Homography, Pointer, Pose, Scene, Up


@dataclass(frozen=True, slots=True)
class TouchFrame:
    """The complete state of one surface at one moment."""

    surface: str
    node: str
    session: str
    frame: int
    time_us: int
    """The frame's time: Unix time when live, the file's own time in replay."""
    pointers: tuple[Pointer, ...]
    """In the order of the alive list."""
    downs: tuple[Down, ...] = ()
    """Touches that began, each reported once."""
    ups: tuple[Up, ...] = ()
    """Touches that ended, each reported once."""
    missed: int = 0
    """Frames that were sent since the last one (by the counter) and never arrived."""
    complete: bool = True
    """False if a part was lost: its pointers stay as in the frame before."""
    session_ms: int = 0
    """Milliseconds since the session's first frame, modulo 2^24."""

    @property
    def events(self) -> tuple[Down | Up, ...]:
        """Downs and ups; those of one finger in order of time."""
        both: tuple[Down | Up, ...] = (*self.downs, *self.ups)
        return tuple(sorted(both, key=in_order))


@dataclass(frozen=True, slots=True)
class Report:
    """A scene, homography, pose or health message of a service."""

    surface: str
    message: Scene | Homography | Pose | Health


@dataclass(frozen=True, slots=True)
class Lost:
    """A session is silent, or a newer one replaced it; its pointers are gone."""

    surface: str
    node: str
    session: str


@dataclass(frozen=True, slots=True)
class Collision:
    """Two running services use one node name; reported once per pair of sessions."""

    surface: str
    node: str
    sessions: tuple[str, str]
    """The older and the newer session, by first arrival."""


Event = TouchFrame | Report | Lost | Collision


def in_order(event: Down | Up) -> tuple[int, int, bool]:
    """Sort key: a finger's touches by number, each begun before it ends."""
    return event.id, event.contacts, isinstance(event, Up)
