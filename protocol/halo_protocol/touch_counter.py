"""Counts each touch once: repeated events are reported once, lost ones are inferred.

Rule: pure bookkeeping over frames. A down or up is sent three times, with the number of its
touch; a pointer carries the count of touches it has begun. So a client that lost all three
copies still sees the hit: it is inferred from the pointer, with `UNKNOWN_STRIKE`.
"""

from __future__ import annotations

from dataclasses import dataclass

from halo_protocol.events import in_order
from halo_protocol.messages import Down, Pointer, Up

UNKNOWN_STRIKE = -1.0
"""`strike_mm_s` of an inferred down."""
MAX_REMEMBERED = 256
"""Fingers that left and may still have repeated events; those of two frames would suffice."""


@dataclass(slots=True)
class _Touches:
    """What was reported of one pointer."""

    slot: int
    u: float
    v: float
    begun: int = 0
    """Number of the last touch with a reported down."""
    ended: int = 0
    """Number of the last touch with a reported up."""


class TouchCounter:
    """The touches of one session, as reported to one client."""

    def __init__(self) -> None:
        self._touches: dict[int, _Touches] = {}
        self._downs: list[Down] = []
        self._ups: list[Up] = []

    def count(
        self,
        pointers: tuple[Pointer, ...],
        events: list[Down | Up],
        *,
        joining: bool = False,
        whole: bool = True,
    ) -> tuple[tuple[Down, ...], tuple[Up, ...]]:
        """The new downs and ups of a frame.

        `joining`: true until the client has seen a whole frame of the session; touches that
        began before are not hits. If a frame is not `whole`, nothing is inferred: the lost
        part may contain the event, and the next frame repeats it.
        """
        for event in sorted(events, key=in_order):
            self._event(event, joining)
        for pointer in pointers:
            touches = self._of(pointer)
            if joining and pointer.contacts > touches.begun:
                touches.begun = pointer.contacts
                touches.ended = pointer.contacts - pointer.touching
            if whole:
                self._infer(pointer, touches)
        living = {pointer.id for pointer in pointers}
        if whole:
            self._end_all_but(living)
        self._forget_all_but(living)
        return self._drain()

    def close(self) -> tuple[Up, ...]:
        """End all open touches, for a service that is lost."""
        self._end_all_but(set())
        return self._drain()[1]

    def _event(self, event: Down | Up, joining: bool) -> None:
        touches = self._of(event)
        number = event.contacts
        if isinstance(event, Up):
            if number <= touches.ended:
                return
            if number > touches.begun and joining:
                touches.begun = touches.ended = number  # It began before we joined.
                return
            self._begin(touches, _inferred_down(event))
            touches.ended = number
            self._ups.append(event)
        else:
            self._begin(touches, event)

    def _infer(self, pointer: Pointer, touches: _Touches) -> None:
        self._begin(touches, _inferred_down(pointer))
        if not pointer.touching:
            self._end(pointer.id, touches)

    def _begin(self, touches: _Touches, down: Down) -> None:
        if down.contacts > touches.begun:
            self._end(down.id, touches)
            touches.begun = down.contacts
            # Touches in between were lost and are over: the number shows it.
            touches.ended = down.contacts - 1
            self._downs.append(down)

    def _end(self, pointer_id: int, touches: _Touches) -> None:
        if touches.ended < touches.begun:
            self._ups.append(Up(pointer_id, touches.slot, touches.u, touches.v, 0.0, touches.begun))
            touches.ended = touches.begun

    def _of(self, seen: Pointer | Down | Up) -> _Touches:
        """The touches of a pointer, with its last place."""
        touches = self._touches.get(seen.id)
        if touches is None:
            touches = self._touches[seen.id] = _Touches(seen.slot, seen.u, seen.v)
        touches.slot, touches.u, touches.v = seen.slot, seen.u, seen.v
        return touches

    def _end_all_but(self, living: set[int]) -> None:
        for key, touches in self._touches.items():
            if key not in living:
                self._end(key, touches)

    def _forget_all_but(self, living: set[int]) -> None:
        gone = [key for key in self._touches if key not in living]
        for key in gone[: max(0, len(gone) - MAX_REMEMBERED)]:
            del self._touches[key]

    def _drain(self) -> tuple[tuple[Down, ...], tuple[Up, ...]]:
        downs, ups = tuple(self._downs), tuple(self._ups)
        self._downs.clear()
        self._ups.clear()
        return downs, ups


def _inferred_down(seen: Pointer | Up) -> Down:
    return Down(seen.id, seen.slot, seen.u, seen.v, UNKNOWN_STRIKE, 0.0, seen.contacts)
