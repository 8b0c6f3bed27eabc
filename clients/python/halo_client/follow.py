"""Chooses the service that a receiver follows: by default one surface of one node.

Rule: pure. Several services may send to one port; a program that draws or makes sound must not mix
their fingers. The first one that sends a frame is followed until it is lost.
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass

from halo_protocol import ANY, Collision, Event, Report, TouchFrame

Key = tuple[str, str, str]
"""(node, surface, session)."""
MAX_RETIRED = 64
"""Replaced sessions that are remembered, so that a running one is not followed again."""


@dataclass(frozen=True, slots=True)
class Follow:
    """What to follow."""

    node: str = ANY
    """The only node to follow, or `ANY`."""
    surface: str = ANY
    """The only surface to follow, or `ANY`."""
    everything: bool = False
    """Whether to report all that match, instead of the first one."""

    def matches(self, node: str, surface: str) -> bool:
        """Whether node and surface are among those to follow."""
        return self.node in (ANY, node) and self.surface in (ANY, surface)


FIRST = Follow()
"""The first service that sends a frame."""


class Follower:
    """The session that is followed now, and what is left out because of that."""

    def __init__(self, follow: Follow) -> None:
        self._follow = follow
        self._retired: deque[Key] = deque(maxlen=MAX_RETIRED)
        self.current: Key | None = None
        self.ignored: set[tuple[str, str]] = set()
        """(node, surface) of other services that were received and not reported."""

    def replaces(self, frame: TouchFrame) -> Key | None:
        """The followed session, if this frame is of a newer session of the same service."""
        key = (frame.node, frame.surface, frame.session)
        if self.current is None or self._follow.everything or key in (self.current, *self._retired):
            return None
        return self.current if key[:2] == self.current[:2] else None

    def retire(self, key: Key) -> None:
        """Stop following a session for good."""
        self._retired.append(key)
        self.current = None

    def accepts(self, event: Event) -> bool:
        """Whether to report an event."""
        if isinstance(event, Report):
            ours = self._reports(event.message.node, event.surface)
            return ours and not self.is_clone(event)
        if isinstance(event, Collision):
            return self._reports(event.node, event.surface)
        key = (event.node, event.surface, event.session)
        if self._follow.everything:
            return self._follow.matches(event.node, event.surface)
        if isinstance(event, TouchFrame):
            return self._accepts_frame(key)
        return self._accepts_loss(key)

    def is_clone(self, report: Report) -> bool:
        """Whether a report is of another service with the name of the one that is followed."""
        if self.current is None or self._follow.everything:
            return False
        node, surface, session = self.current
        named = (report.message.node, report.surface) == (node, surface)
        return named and report.message.session != session

    def _reports(self, node: str, surface: str) -> bool:
        if self.current is None or self._follow.everything:
            return self._follow.matches(node, surface)
        return self.current[:2] == (node, surface)

    def _accepts_frame(self, key: Key) -> bool:
        free = self.current is None and key not in self._retired
        if free and self._follow.matches(*key[:2]):
            self.current = key
        if self.current == key:
            return True
        if self.current is None or key[:2] != self.current[:2]:
            self._ignore(key)
        return False

    def _accepts_loss(self, key: Key) -> bool:
        followed = key == self.current
        if followed:
            self.current = None
        if key in self._retired:
            self._retired.remove(key)
        return followed

    def _ignore(self, key: Key) -> None:
        if len(self.ignored) < MAX_RETIRED:
            self.ignored.add(key[:2])
