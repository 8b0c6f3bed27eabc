"""Makes the pointers of several nodes the pointers of one canvas.

Rule: pure; times are arguments. Each frame of a node updates tracks; a frame of the canvas reads
them. A pointer that two nodes see is one track; its id, slot and touches do not change while the
nodes that see it change.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import count

import halo_protocol as wire
from halo_service.canvas.association import APART_US, assign, doubles, is_apart, load_solver
from halo_service.canvas.detections import Area, Detection, Member, NodeEvent, Place, SurfaceKey
from halo_service.canvas.touches import Change
from halo_service.canvas.tracks import IN_AIR, Track, decide_sides
from halo_service.values import Pointer, TouchEvent

RETURN_MM = 30.0
"""Greatest distance from another surface at which a finger that vanishes may appear there."""
ONE_US = 50_000
"""Time after which two tracks that seem to be one finger are merged."""


@dataclass(slots=True)
class _Sent:
    """A touch that began or ended since the last frame."""

    track: Track
    change: Change


@dataclass(frozen=True, slots=True)
class NodeFrame:
    """A frame of one node on the canvas."""

    surface: SurfaceKey
    time_us: int
    """On the canvas's clock."""
    pointers: tuple[Detection, ...] = ()
    events: tuple[tuple[Member, wire.Down | wire.Up, NodeEvent], ...] = ()
    """Those of one finger in order of time."""


@dataclass(slots=True)
class Fusion:
    """All fingers on the canvas."""

    areas: Mapping[SurfaceKey, Area]
    tracks: list[Track] = field(default_factory=list)
    _ids: Iterator[int] = field(default_factory=lambda: count(1))
    _changes: list[_Sent] = field(default_factory=list)
    _one_since_us: dict[tuple[int, int], int] = field(default_factory=dict)

    def __post_init__(self) -> None:
        """Import the solver now: at the first finger it would delay frames by half a second."""
        load_solver()

    @property
    def has_news(self) -> bool:
        """Whether a touch began or ended since the last frame."""
        return bool(self._changes)

    def receive(self, frame: NodeFrame) -> None:
        """Note a node's frame."""
        by_member = {each.member: each for each in frame.pointers}
        known = self._tracks_on(frame.surface)
        for member in known.keys() & by_member.keys():
            known[member].update(by_member[member])
        # First what is gone: its track is free for a new pointer of the same node.
        for member in known.keys() - by_member.keys():
            self._vanish(known[member], member, frame)
        self._start([each for each in frame.pointers if each.member not in known], frame)
        self._touch(frame)
        self._correct(frame)

    def lose(self, surface: SurfaceKey, time_us: int) -> None:
        """Forget all that a node reported: it is gone."""
        for member, track in self._tracks_on(surface).items():
            event = NodeEvent(time_us, track.place_mm(time_us))
            self._note(track, track.touches.drop(member, event))
            track.remove(member, time_us)
            if not track.members:
                self._end(track, time_us)

    def frame(self, time_us: int) -> tuple[tuple[Pointer, ...], tuple[TouchEvent, ...]]:
        """Return the pointers at a time, and the events since the last frame."""
        for track in list(self.tracks):
            self._note(track, track.decide_touches(time_us))
            if track.is_over(time_us):
                self._end(track, time_us)
            track.decide_finger()
        decide_sides(self.tracks)
        events = tuple(self._event(each, time_us) for each in self._changes)
        self._changes.clear()
        return tuple(each.pointer(time_us) for each in self.tracks), events

    def _tracks_on(self, surface: SurfaceKey) -> dict[Member, Track]:
        """Return the tracks of a node's pointers."""
        return {
            member: track
            for track in self.tracks
            for member in track.members
            if member[0] == surface
        }

    def _vanish(self, track: Track, member: Member, frame: NodeFrame) -> None:
        """End a member whose pointer is not in its node's frame any more."""
        last = [event for each, up, event in frame.events if each == member and _is_up(up)]
        for each, message, event in frame.events:
            if each == member and not (last and event is last[-1]):
                self._change(track, member, message, event)
        returns = self._is_near_another(track.place_mm(frame.time_us), frame.surface)
        event = last[-1] if last else NodeEvent(frame.time_us, track.place_mm(frame.time_us))
        self._note(track, track.touches.up(member, event, vanished=True, returns=returns))
        track.remove(member, frame.time_us)
        if not track.members and not returns:
            self._end(track, frame.time_us)

    def _is_near_another(self, place_mm: Place, mine: SurfaceKey) -> bool:
        """Whether a place is near to the surface of another node, where a finger may appear."""
        return any(
            area.size_mm is not None and area.inside_mm(place_mm) > -RETURN_MM
            for surface, area in self.areas.items()
            if surface != mine
        )

    def _start(self, new: Sequence[Detection], frame: NodeFrame) -> None:
        """Assign new pointers of a node to tracks that it does not see yet, or start tracks."""
        free = [track for track in self.tracks if self._is_free(track, frame.surface)]
        assigned = assign(free, new, frame.time_us)
        for number, seen in enumerate(new):
            if number in assigned:
                self._replace(free[assigned[number]], seen)
            elif len(self.tracks) < wire.MAX_POINTERS and not self._waits(seen, frame):
                self.tracks.append(self._started(seen))

    @staticmethod
    def _is_free(track: Track, surface: SurfaceKey) -> bool:
        """Whether a node may have a new pointer for a track: it sees none, or one hardly."""
        mine = [seen for (node, _), seen in track.members.items() if node == surface]
        return all(seen.weak or is_apart(track, seen) for seen in mine)

    def _replace(self, track: Track, seen: Detection) -> None:
        """Give a track a node's new pointer instead of a weak one of this node."""
        old = [member for member in track.members if member[0] == seen.member[0]]
        touched = any(track.touches.has_down(member) for member in old)
        track.update(seen)
        for member in old:
            event = NodeEvent(seen.time_us, seen.place_mm)
            self._note(track, track.touches.up(member, event, vanished=True, returns=touched))
            track.remove(member, seen.time_us)

    def _waits(self, seen: Detection, frame: NodeFrame) -> bool:
        """Whether to start no track yet: the pointer is weak, and another node may see it, or its
        own node sees a finger of this name better."""
        if not seen.weak or seen.pointer.touching:
            return False
        better = any(
            each.name == seen.name and seen.is_weaker(each)
            for each in frame.pointers
            if each is not seen
        )
        return better or self._is_near_another(seen.place_mm, seen.member[0])

    def _started(self, seen: Detection) -> Track:
        slots = {track.slot for track in self.tracks}
        slot = next(each for each in count() if each not in slots)
        track = Track(next(self._ids), slot, seen)
        track.update(seen)
        return track

    def _touch(self, frame: NodeFrame) -> None:
        """Note the downs and ups of pointers that are there, and touches without a down."""
        known = self._tracks_on(frame.surface)
        for member, message, event in frame.events:
            if member in known:
                self._change(known[member], member, message, event)
        for member, track in known.items():
            seen = track.members[member]
            event = NodeEvent(seen.time_us, seen.place_mm)
            if seen.pointer.touching and not track.touches.has_down(member):
                self._down(track, member, event)
            elif not seen.pointer.touching and track.touches.has_down(member):
                self._up(track, member, event)

    def _change(
        self, track: Track, member: Member, message: wire.Down | wire.Up, event: NodeEvent
    ) -> None:
        if _is_up(message):
            self._up(track, member, event)
        elif not track.touches.has_down(member):
            self._down(track, member, event)

    def _up(self, track: Track, member: Member, event: NodeEvent) -> None:
        unsure = track.is_unsure(member, event.time_us)
        returns = unsure and self._is_near_another(track.place_mm(event.time_us), member[0])
        self._note(track, track.touches.up(member, event, returns=returns))

    def _down(self, track: Track, member: Member, event: NodeEvent) -> None:
        discovered = track.in_air.get(member, 0) < IN_AIR
        track.in_air[member] = 0
        self._note(track, track.touches.down(member, event, discovered=discovered))

    def _correct(self, frame: NodeFrame) -> None:
        """Undo wrong assignments: separate what is too far apart, merge what is one finger."""
        for member, track in self._tracks_on(frame.surface).items():
            seen = track.members[member]
            if len(track.members) == 1 or not is_apart(track, seen):
                track.apart_us.pop(member, None)
            elif frame.time_us - track.apart_us.setdefault(member, frame.time_us) > APART_US:
                event = NodeEvent(frame.time_us, seen.place_mm)
                self._note(track, track.touches.drop(member, event))
                track.remove(member, frame.time_us)
        one = {(a.id, b.id): (a, b) for a, b in doubles(self.tracks, frame.time_us)}
        since_us = self._one_since_us
        self._one_since_us = {each: since_us.get(each, frame.time_us) for each in one}
        for pair, began_us in self._one_since_us.items():
            if frame.time_us - began_us > ONE_US and one[pair][1] in self.tracks:
                self._merge(*one[pair], frame.time_us)

    def _merge(self, track: Track, other: Track, time_us: int) -> None:
        """Make a younger track a part of an older one."""
        track.touches.absorb(other.touches)
        for seen in list(other.members.values()):
            if seen.member[0] not in track.nodes or not seen.weak:
                self._replace(track, seen)
        self._end(other, time_us)

    def _end(self, track: Track, time_us: int) -> None:
        event = NodeEvent(time_us, track.place_mm(time_us))
        self._note(track, track.touches.end(event))
        self.tracks.remove(track)

    def _note(self, track: Track, changes: Sequence[Change]) -> None:
        self._changes += [_Sent(track, each) for each in changes]

    def _event(self, sent: _Sent, time_us: int) -> TouchEvent:
        track, change = sent.track, sent.change
        x_mm, y_mm = change.event.place_mm
        return TouchEvent(
            kind=change.kind,
            id=track.id,
            slot=track.slot,
            x_mm=x_mm,
            y_mm=y_mm,
            strike_mm_s=change.event.strike_mm_s if change.kind == "down" else 0.0,
            ago_ms=max(time_us - change.event.time_us, 0) / 1000.0,
            contacts=change.number,
        )


def _is_up(message: wire.Down | wire.Up) -> bool:
    return isinstance(message, wire.Up)
