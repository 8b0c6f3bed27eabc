"""A finger on the canvas, over all nodes that see it."""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Iterable

import halo_protocol as wire
from halo_service.canvas.blend import Blend, velocity
from halo_service.canvas.detections import Detection, Member, Place, SurfaceKey
from halo_service.canvas.touches import RETURN_US, Change, MergedTouches
from halo_service.values import Diagnostics, Finger, Pointer, Side, Touch

LEAST_PRESSURE = 0.02
"""Of a touch, as the protocol has it."""
IN_AIR = 2
"""Number of frames after which a node is sure that a finger is in the air; one may be an error."""
RECENT_US = 150_000
"""A node may notice the touch of a finger late for this time after it has found it."""
DRAW = 0.1
"""What is added to the share of the present finger or side, so that it stays."""
NO_DIAGNOSTICS = Diagnostics((0.0, 0.0, 0.0), (0.0, 0.0), *([math.nan] * 6))
"""Written by replay, and unknown here."""


class Track:
    """One finger; its id and slot never change."""

    def __init__(self, id: int, slot: int, seen: Detection) -> None:  # noqa: A002 - the wire's name
        self.id, self.slot = id, slot
        self.blend = Blend(seen)
        self.touches = MergedTouches()
        self.first_us: dict[Member, int] = {}
        """Since when each member is seen."""
        self.in_air: dict[Member, int] = {}
        """In how many of its last frames each member saw the finger well, and in the air."""
        self.coasted_us: dict[Member, int] = {}
        """When each member's node last reported it without seeing it."""
        self.vanished_us: int | None = None
        """Since when no node sees it; None: one does."""
        self.side = Side.UNKNOWN
        self.apart_us: dict[Member, int] = {}
        """Since when a member is too far from the others."""
        self._pressure = LEAST_PRESSURE
        self.finger = _finger(seen.pointer.finger)

    @property
    def members(self) -> dict[Member, Detection]:
        """The reports of all nodes that see it."""
        return self.blend.seen

    @property
    def nodes(self) -> set[SurfaceKey]:
        """The surfaces on which it is seen."""
        return {surface for surface, _ in self.members}

    def is_reliable_on(self, surface: SurfaceKey) -> bool:
        """Whether its pointer on a surface is reliable: this node sees it well, or no node does."""
        sure = {node for (node, _), seen in self.members.items() if not seen.weak}
        return surface in sure or not sure

    def place_mm(self, time_us: int) -> Place:
        """Return where it is at a time."""
        return self.blend.place_mm(time_us)

    def update(self, seen: Detection) -> None:
        """Note a newer report of a node."""
        self.vanished_us = None
        before = self.members.get(seen.member)
        if seen.weak or (before is not None and before.coasts(seen)):
            self.coasted_us[seen.member] = seen.time_us
        self.blend.update(seen)
        self.first_us.setdefault(seen.member, seen.time_us)
        if seen.pointer.touching:
            return  # when its down arrives, the count begins again
        in_air = self.in_air.get(seen.member, 0)
        self.in_air[seen.member] = in_air if seen.weak else in_air + 1

    def remove(self, member: Member, time_us: int) -> None:
        """End a node's report."""
        self.blend.remove(member, time_us)
        self.first_us.pop(member, None)
        self.coasted_us.pop(member, None)
        self.in_air.pop(member, None)
        self.apart_us.pop(member, None)
        if not self.members:
            self.vanished_us = time_us

    def is_unsure(self, member: Member, time_us: int) -> bool:
        """Whether a release that a node reports may be none.

        The node has lost the finger, or another node has found it just now and may not have
        noticed the touch yet.
        """
        if time_us - self.coasted_us.get(member, -RECENT_US) < RECENT_US:
            return True
        others = (first for other, first in self.first_us.items() if other != member)
        return any(time_us - first < RECENT_US for first in others)

    def decide_touches(self, time_us: int) -> list[Change]:
        """End or begin touches that waited for another node's report."""
        newest_us = max(self.first_us.values(), default=time_us)
        lifted = [self.in_air.get(each, 0) >= IN_AIR for each in self.members]
        return self.touches.decide(
            time_us,
            fresh=time_us - newest_us < RECENT_US,
            lifted=len(lifted) > 1 and all(lifted),
        )

    def is_over(self, time_us: int) -> bool:
        """Whether no node has seen it for longer than a return takes."""
        return self.vanished_us is not None and time_us - self.vanished_us > RETURN_US

    def decide_finger(self) -> None:
        """Choose the finger with the most weight; the present one wins a draw."""
        shares = defaultdict(float, {self.finger: DRAW})
        for member, seen in self.members.items():
            shares[_finger(seen.pointer.finger)] += self.blend.share(member)
        self.finger = max(shares, key=lambda each: shares[each])

    def pointer(self, time_us: int) -> Pointer:
        """Return it as it is sent, at a time."""
        touching = self.touches.touching
        x_mm, y_mm = self.place_mm(time_us)
        vx_mm_s, vy_mm_s = velocity(self.blend, time_us)
        return Pointer(
            id=self.id,
            slot=self.slot,
            side=self.side,
            finger=self.finger,
            state=Touch.TOUCH if touching else Touch.HOVER,
            x_mm=x_mm,
            y_mm=y_mm,
            hover_mm=0.0 if touching else self._hover_mm(time_us),
            pressure=self._touch_pressure(time_us) if touching else 0.0,
            force_g=self._force_g(time_us),
            vx_mm_s=vx_mm_s,
            vy_mm_s=vy_mm_s,
            confidence=self.blend.best().pointer.confidence,
            contacts=self.touches.count,
            diagnostics=NO_DIAGNOSTICS,
        )

    def _hover_mm(self, time_us: int) -> float:
        in_air = {member for member, each in self.members.items() if not each.pointer.touching}
        mean_mm = self.blend.mean(lambda each: each.pointer.hover_mm, in_air, time_us)
        return _finite(mean_mm, self.blend.best().pointer.hover_mm)

    def _touch_pressure(self, time_us: int) -> float:
        """Return the pressure; the last one while no node sees the touch."""
        holders = self.touches.holders
        mean = self.blend.mean(lambda each: each.pointer.pressure, holders, time_us)
        self._pressure = max(_finite(mean, self._pressure), LEAST_PRESSURE)
        return self._pressure

    def _force_g(self, time_us: int) -> float:
        """Return the force by the nodes that measure it; -1 where none does."""
        measured = {
            member
            for member, each in self.members.items()
            if each.pointer.force_g >= 0.0
            and (member in self.touches.holders or not self.touches.touching)
        }
        mean_g = self.blend.mean(lambda each: each.pointer.force_g, measured, time_us)
        return _finite(mean_g, -1.0)


def decide_sides(tracks: Iterable[Track]) -> None:
    """Give all fingers of one hand the same side.

    Fingers that one node sees on one side belong together, and so do all nodes' reports of one
    finger: what is connected in this way is one hand. Where that would give a hand a finger twice,
    a node has confused the sides, and each finger has the side that most weight says.
    """
    for hand in _hands(list(tracks)):
        fingers = [each.finger for each in hand]
        groups = [hand] if len(set(fingers)) == len(fingers) else [[each] for each in hand]
        for group in groups:
            side = _side(group)
            for each in group:
                each.side = side


def _hands(tracks: list[Track]) -> list[list[Track]]:
    hands: list[tuple[set[tuple[SurfaceKey, int]], list[Track]]] = []
    for track in tracks:
        seen_as = {(surface, seen.pointer.hand) for (surface, _), seen in track.members.items()}
        seen_as = {each for each in seen_as if each[1] != Side.UNKNOWN}
        joined = [hand for hand in hands if hand[0] & seen_as]
        hands = [hand for hand in hands if not hand[0] & seen_as]
        names = seen_as.union(*(hand[0] for hand in joined))
        hands.append((names, [*(each for hand in joined for each in hand[1]), track]))
    return [members for _, members in hands]


def _side(tracks: list[Track]) -> Side:
    shares: defaultdict[Side, float] = defaultdict(float)
    for track in tracks:
        shares[track.side] += DRAW
        for member, seen in track.members.items():
            if seen.pointer.hand in (Side.LEFT, Side.RIGHT):
                shares[Side(seen.pointer.hand)] += track.blend.share(member)
    shares.pop(Side.UNKNOWN, None)
    return max(shares, key=lambda each: shares[each], default=Side.UNKNOWN)


def _finger(number: int) -> Finger:
    """Return the finger; a number of a later protocol version counts as an index finger."""
    return Finger(number) if number in wire.Finger._value2member_map_ else Finger.INDEX


def _finite(value: float, otherwise: float) -> float:
    return otherwise if math.isnan(value) else value
