"""The touches of one finger that several nodes report: each is counted once.

Rule: pure; times are arguments. A touch lasts while one node sees it. So a touch that one node
misses is not lost, and a touch that moves from one node's surface to another's goes on.

    A   ____/-----------\\______      down of A: a touch begins
    B   ______/-----------\\____      down of B, up to 80 ms later: the same touch
    C   ____/---------------\\__      down of A, up of B
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from halo_service.canvas.detections import Member, NodeEvent

SAME_US = 80_000
"""Downs of two nodes within this time are one: they differ by up to two frames. People tap with one
finger at most every 100 ms."""
ORDER_US = 40_000
"""A down that is reported up to this time before another node's up may be after it: both times have
errors."""
RETURN_US, LONGEST_US = 150_000, 300_000
"""How long the up of a finger that vanished at a seam while it touched waits for the other side,
and how long where the finger has appeared there and still seems to hover."""


@dataclass(frozen=True, slots=True)
class Change:
    """A touch of the canvas began or ended."""

    kind: Literal["down", "up"]
    event: NodeEvent
    number: int
    """Of the touch."""


@dataclass(frozen=True, slots=True)
class _Hold:
    """A node's part of a touch."""

    event: NodeEvent
    discovered: bool
    """The finger touched when this node saw it first, or a moment later."""


class MergedTouches:
    """The touches of one pointer of the canvas."""

    def __init__(self) -> None:
        self.count = 0
        """Touches so far."""
        self.touching = False
        self._began_us = self._ended_us = 0
        self._holds: dict[Member, _Hold] = {}
        self._late: dict[Member, _Hold] = {}
        """Those that report a touch which is over for the others."""
        self._took_part: set[Member] = set()
        self._awaited: NodeEvent | None = None
        """The end of the touch, which is sent unless a node soon sees that it goes on."""
        self._lifted_us: int | None = None
        """When a node saw the finger leave; None: in this touch, none has."""

    @property
    def holders(self) -> set[Member]:
        """Which nodes' pointers touch now, as part of the open touch."""
        return set(self._holds)

    def has_down(self, member: Member) -> bool:
        """Whether the down of a member's present touch was seen."""
        return member in self._holds or member in self._late

    def down(self, member: Member, event: NodeEvent, *, discovered: bool) -> list[Change]:
        """Note a down; `discovered`: the node did not see the finger in the air before."""
        hold = _Hold(event, discovered)
        again = member in self._took_part
        same = not again and event.time_us - self._began_us <= SAME_US and self.count > 0
        if not self.touching:
            if same:
                self._late[member] = hold
                self._took_part.add(member)
                return []
            return [self._open({member: hold})]
        goes_on = same or (discovered and not again)
        if self._awaited is not None and self._was_lifted(self._awaited) and not goes_on:
            return [self._close(self._awaited), self._open({member: hold})]
        self._holds[member] = hold
        self._took_part.add(member)
        self._awaited = None
        return []

    def up(
        self, member: Member, event: NodeEvent, *, vanished: bool = False, returns: bool = False
    ) -> list[Change]:
        """Note an up; `vanished`: its pointer is gone; `returns`: a node may soon see that the
        finger touches on."""
        if self._late.pop(member, None) or self._holds.pop(member, None) is None:
            return []
        if not vanished:
            self._lifted_us = event.time_us
        if self._holds:
            return [] if vanished or not self._is_next_touch(event) else self._split(event)
        if returns and not (vanished and self._was_lifted(event)):
            self._awaited = event
            return []
        return [self._close(event)]

    def drop(self, member: Member, event: NodeEvent) -> list[Change]:
        """Forget a member; a touch that it alone held ends."""
        self._late.pop(member, None)
        held = self._holds.pop(member, None) is not None
        return [self._close(event)] if held and not self._holds else []

    def decide(self, now_us: int, *, fresh: bool = False, lifted: bool = False) -> list[Change]:
        """End or begin touches that waited long enough for another node's report.

        `fresh`: a node has just found the finger; `lifted`: several see it in the air.
        """
        changes: list[Change] = []
        longest_us = 0 if lifted else LONGEST_US if fresh else RETURN_US
        if self._awaited is not None and now_us - self._awaited.time_us > longest_us:
            changes.append(self._close(self._awaited))
        if self._late and now_us - self._ended_us > SAME_US:
            late, self._late = self._late, {}
            if self.touching:
                self._holds |= late
            else:
                changes.append(self._open(late))
        return changes

    def end(self, event: NodeEvent) -> list[Change]:
        """End the open touch, if there is one."""
        self._holds.clear()
        self._late.clear()
        return [self._close(event)] if self.touching else []

    def absorb(self, other: MergedTouches) -> None:
        """Take over the parts of another pointer, which is the same finger."""
        if self.touching:
            self._holds |= other._holds
        self._late |= other._late if self.touching else other._late | other._holds
        self._took_part |= other._took_part

    def _was_lifted(self, event: NodeEvent) -> bool:
        """Whether a node saw the finger leave about then."""
        lifted_us = self._lifted_us
        return lifted_us is not None and abs(event.time_us - lifted_us) <= SAME_US

    def _is_next_touch(self, up: NodeEvent) -> bool:
        """Whether those that still touch have begun a touch after the one that ends."""
        return all(
            not hold.discovered
            and hold.event.time_us >= up.time_us - ORDER_US
            and hold.event.time_us - self._began_us > SAME_US
            for hold in self._holds.values()
        )

    def _split(self, up: NodeEvent) -> list[Change]:
        holds = dict(self._holds)
        return [self._close(up), self._open(holds)]

    def _open(self, holds: dict[Member, _Hold]) -> Change:
        event = min((hold.event for hold in holds.values()), key=lambda each: each.time_us)
        self.count += 1
        self.touching = True
        self._began_us = event.time_us
        self._holds = dict(holds)
        self._took_part = set(holds)
        self._awaited = self._lifted_us = None
        return Change("down", event, self.count)

    def _close(self, event: NodeEvent) -> Change:
        self.touching = False
        self._ended_us = event.time_us
        self._holds = {}
        self._awaited = None
        return Change("up", event, self.count)
