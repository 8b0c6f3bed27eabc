"""What a client is told, once datagrams are put together.

Rule: values only.
"""

from __future__ import annotations

from dataclasses import dataclass

from halo_protocol.messages import Down, Health, Homography, Pointer, Pose, Scene, Up


@dataclass(frozen=True, slots=True)
class TouchFrame:
    """The whole truth of one moment on one surface."""

    surface: str
    node: str
    session: str
    frame: int
    time_us: int
    """The frame's time: Unix time when live, the file's own time in replay."""
    pointers: tuple[Pointer, ...]
    """In the order of the alive list."""
    downs: tuple[Down, ...] = ()
    """Touches that began and were not told before."""
    ups: tuple[Up, ...] = ()
    """Touches that ended and were not told before."""
    missed: int = 0
    """Frames that the counter says were sent since the last one, and that never came."""
    complete: bool = True
    """False where a part was lost: pointers of that part stay as they were last seen."""

    @property
    def events(self) -> tuple[Down | Up, ...]:
        """Downs and ups, those of each finger in the order in which they happened."""
        both: tuple[Down | Up, ...] = (*self.downs, *self.ups)
        return tuple(sorted(both, key=in_order))


@dataclass(frozen=True, slots=True)
class Report:
    """What a service says about itself: how it sees, where things are, how it fares."""

    surface: str
    message: Scene | Homography | Pose | Health


@dataclass(frozen=True, slots=True)
class Lost:
    """A service has gone silent, or made room for its next session; its pointers are closed."""

    surface: str
    node: str
    session: str


Event = TouchFrame | Report | Lost


def in_order(event: Down | Up) -> tuple[int, int, bool]:
    """Sort key: a finger's touches by number, each begun before it ends."""
    return event.id, event.contacts, isinstance(event, Up)
