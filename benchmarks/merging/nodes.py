"""What a node reports of true fingers, with the errors that nodes have, as datagrams.

Errors: a place that is off by its calibration (a fixed vector and a stretch) and by noise, more at
the edge; a finger that is found 1 to 3 frames late at the edge, and is lost for some frames now and
then; a touch that is noticed late or, once in fifty, not at all; a clock that is off and drifts;
frames that wait on their way, and that are lost. A touch is missed, and a finger lost, only where
another node sees it, so that each lost or doubled down is an error of the merging.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np

import halo_protocol as wire
from halo_service.outputs.frame_encoder import FrameEncoder
from halo_service.values import Diagnostics, Finger, Pointer, Side, Touch, TouchEvent, TouchFrame

from .truth import Finger as TrueFinger
from .truth import Truth

EDGE_MM = 15.0
BEYOND_MM = 8.0
"""Distance outside of the surface up to which a finger is seen."""
NO_DIAGNOSTICS = Diagnostics((0.0, 0.0, 0.0), (0.0, 0.0), *([math.nan] * 6))


@dataclass(frozen=True, slots=True)
class Errors:
    """How bad a node is."""

    bias_mm: float = 1.0
    noise_mm: float = 0.8
    lost_per_s: float = 0.3
    """How often a finger is lost, in the overlap."""
    missed: float = 0.02
    """Share of touches that are not seen at all, in the overlap."""
    event_ms: float = 8.0
    """Standard deviation of the time of a down or up."""
    clock_s: float = 5.0
    drift: float = 60e-6
    latency_ms: tuple[float, float] = (18.0, 28.0)
    """Range of the shortest delay, of which the node reports all but the network's part."""
    network_ms: tuple[float, float] = (0.3, 3.0)
    jitter_ms: float = 2.0
    pauses: float = 0.01
    """Share of frames that wait for 40 ms more."""
    lost_frames: float = 0.005


@dataclass(slots=True)
class _Seen:
    """What a node has seen of a finger."""

    id: int
    slot: int
    since_s: float
    contacts: int = 0
    touching: bool = False
    down_late_s: float = 0.0
    up_late_s: float = 0.0
    missed: bool = False
    touch: int = -1
    frames: int = 0


@dataclass(frozen=True, slots=True)
class Arrival:
    """A datagram at the canvas."""

    arrival_s: float
    node: str
    datagram: bytes


@dataclass
class SimulatedNode:
    """One node with a rectangle of the canvas as its surface."""

    name: str
    rectangle_mm: tuple[float, float, float, float]
    """x, y, width, height on the canvas."""
    random: np.random.Generator
    errors: Errors = Errors()
    rate_hz: float = 30.0
    unix_s: float = 1_700_000_000.0
    fingers: dict[int, _Seen] = field(default_factory=dict)
    lost_until_s: dict[int, float] = field(default_factory=dict)
    losses: set[int] = field(default_factory=set)
    """Fingers that were lost in the overlap."""
    next_id: int = 1
    peers: list[SimulatedNode] = field(default_factory=list)
    """The other nodes."""

    def __post_init__(self) -> None:
        """Choose the errors that do not change."""
        errors, random = self.errors, self.random
        self.bias = random.normal(0.0, errors.bias_mm, 2)
        self.stretch = random.normal(1.0, 0.006, 2)
        self.clock_s = random.uniform(-errors.clock_s, errors.clock_s)
        self.drift = random.uniform(-errors.drift, errors.drift)
        self.latency_ms = random.uniform(*errors.latency_ms)
        self.network_ms = random.uniform(*errors.network_ms)
        self.encoder = FrameEncoder(self.name, f"s{self.name}", 0, again_ms=400.0)

    @property
    def scene(self) -> wire.Scene:
        """The surface's size."""
        _, _, width, height = self.rectangle_mm
        return wire.Scene(
            self.name, f"s{self.name}", wire.VERSION, width, height, 2, 1, 2, self.rate_hz
        )

    @property
    def health(self) -> wire.Health:
        """What the node says of its latency."""
        return wire.Health(self.name, f"s{self.name}", self.rate_hz, self.latency_ms, 0, 0, 3, 1)

    def stream(self, truth: Truth) -> Iterator[Arrival]:
        """Yield all datagrams in the order in which they are sent."""
        phase_s = self.random.uniform(0.0, 1.0 / self.rate_hz)
        arrival_s = 0.0
        for number in range(int(truth.end_s * self.rate_hz)):
            t_s = number / self.rate_hz + phase_s
            outgoing = self.encoder.encode(self.frame(truth, t_s))
            lost = self.random.random() < self.errors.lost_frames
            delay_ms = (
                self.latency_ms + self.network_ms + self.random.gamma(0.7, self.errors.jitter_ms)
            )
            delay_ms += 40.0 * (self.random.random() < self.errors.pauses)
            arrival_s = max(arrival_s, t_s + delay_ms / 1000.0)
            if not lost:
                for datagram in outgoing.datagrams:
                    yield Arrival(arrival_s, self.name, datagram)

    def frame(self, truth: Truth, t_s: float) -> TouchFrame:
        """Return what it reports at a time."""
        time_us = round((self.unix_s + t_s * (1.0 + self.drift) + self.clock_s) * 1e6)
        there = {n: f for n, f in truth.at(t_s) if self._sees(n, f, t_s)}
        events = [
            self._event("up", self.fingers[n], truth.fingers[n], t_s, t_s)
            for n in list(self.fingers)
            if n not in there and self.fingers[n].touching
        ]
        for n in [n for n in self.fingers if n not in there]:
            del self.fingers[n]
        pointers = []
        for n, finger in there.items():
            seen = self.fingers.get(n) or self._found(n, t_s)
            seen.frames += 1
            events += self._touch(n, seen, finger, t_s)
            pointers.append(self._pointer(seen, finger, t_s))
        _, _, width, height = self.rectangle_mm
        return TouchFrame(time_us, "table", width, height, tuple(pointers), tuple(events))

    def _sees(self, number: int, finger: TrueFinger, t_s: float) -> bool:
        place = finger.place_mm(t_s)
        if inside_mm(self.rectangle_mm, place) < -BEYOND_MM:
            self.lost_until_s.pop(number, None)
            return False
        until_s = self.lost_until_s.get(number)
        if until_s is None:  # it comes in: found after 1 to 3 frames
            until_s = t_s + self.random.integers(0, 3) / self.rate_hz - 1e-6
            self.lost_until_s[number] = until_s
        elif (
            t_s > until_s
            and self._other_sees(number, place)
            and self.random.random() < self.errors.lost_per_s / self.rate_hz
        ):
            self.lost_until_s[number] = t_s + self.random.integers(1, 7) / self.rate_hz
            self.losses.add(number)
        elif number in self.losses and not any(number in peer.fingers for peer in self.peers):
            self.losses.remove(number)  # it is found again where no other node sees it
            self.lost_until_s[number] = t_s - 1e-6
        return t_s > self.lost_until_s[number]

    def _other_sees(self, number: int, place: tuple[float, float]) -> bool:
        """Whether another node sees a finger well, and better than this one."""
        mine = (inside_mm(self.rectangle_mm, place), self.name)
        return any(
            number in peer.fingers
            and peer.fingers[number].frames > 6
            and (inside_mm(peer.rectangle_mm, place), peer.name) > mine
            for peer in self.peers
        )

    def _found(self, number: int, t_s: float) -> _Seen:
        taken = {each.slot for each in self.fingers.values()}
        slot = next(each for each in range(64) if each not in taken)
        seen = self.fingers[number] = _Seen(self.next_id, slot, t_s)
        self.next_id += 1
        return seen

    def _touch(self, of: int, seen: _Seen, finger: TrueFinger, t_s: float) -> list[TouchEvent]:
        """Follow the true touches; each is noticed 5 to 40 ms late."""
        events = []
        for number, (down_s, up_s) in enumerate(finger.touches):
            if number > seen.touch and t_s >= down_s:
                if up_s < t_s - 0.05:
                    seen.touch = number
                    continue
                seen.touch = number
                seen.down_late_s = self.random.uniform(0.0, 0.035)
                seen.up_late_s = self.random.uniform(seen.down_late_s, 0.035)
                fresh = down_s < seen.since_s  # it touched before it was found
                seen.missed = bool(
                    not fresh
                    and self._other_sees(of, finger.place_mm(down_s))
                    and self.random.random() < self.errors.missed
                )
        if seen.touch < 0:
            return events
        down_s, up_s = finger.touches[seen.touch]
        if seen.touching and t_s >= up_s + seen.up_late_s:
            seen.touching = False
            events.append(self._event("up", seen, finger, up_s, t_s))
        elif (
            not seen.touching
            and not seen.missed
            and down_s + seen.down_late_s <= t_s < up_s + seen.up_late_s
            and seen.frames > 1  # a finger that is found while it touches seems to hover at first
        ):
            seen.touching = True
            seen.contacts += 1
            events.append(self._event("down", seen, finger, max(down_s, t_s - 0.033), t_s))
        return events

    def _event(
        self, kind: str, seen: _Seen, finger: TrueFinger, at_s: float, t_s: float
    ) -> TouchEvent:
        x, y = self._measured(finger, at_s, 0.0)
        ago_ms = max((t_s - at_s) * 1e3 + self.random.normal(0.0, self.errors.event_ms), 0.0)
        strike = 200.0 if kind == "down" else 0.0
        return TouchEvent(
            "down" if kind == "down" else "up",
            seen.id,
            seen.slot,
            x,
            y,
            strike,
            ago_ms,
            seen.contacts,
        )

    def _pointer(self, seen: _Seen, finger: TrueFinger, t_s: float) -> Pointer:
        inside = inside_mm(self.rectangle_mm, finger.place_mm(t_s))
        worse = 1.0 + math.exp(-max(inside, 0.0) / EDGE_MM)
        x, y = self._measured(finger, t_s, self.errors.noise_mm * worse)
        vx, vy = finger.velocity_mm_s(t_s) + self.random.normal(0.0, 20.0 * worse, 2)
        touching = seen.touching
        return Pointer(
            id=seen.id, slot=seen.slot, side=Side(finger.hand), finger=Finger(finger.finger),
            state=Touch.TOUCH if touching else Touch.HOVER, x_mm=x, y_mm=y,
            hover_mm=0.0 if touching else 8.0, pressure=0.5 if touching else 0.0,
            force_g=-1.0, vx_mm_s=float(vx), vy_mm_s=float(vy),
            confidence=float(np.clip(self.random.normal(0.85, 0.08) / worse**0.5, 0.05, 1.0)),
            contacts=seen.contacts, diagnostics=NO_DIAGNOSTICS,
        )  # fmt: skip

    def _measured(self, finger: TrueFinger, t_s: float, noise_mm: float) -> tuple[float, float]:
        x0, y0, width, height = self.rectangle_mm
        x, y = finger.place_mm(t_s)
        middle = width / 2.0, height / 2.0
        noise = self.random.normal(0.0, noise_mm, 2) if noise_mm else (0.0, 0.0)
        return (
            middle[0] + (x - x0 - middle[0]) * self.stretch[0] + self.bias[0] + float(noise[0]),
            middle[1] + (y - y0 - middle[1]) * self.stretch[1] + self.bias[1] + float(noise[1]),
        )


def inside_mm(rectangle: tuple[float, float, float, float], place: tuple[float, float]) -> float:
    """How far inside of a rectangle a place is; negative outside."""
    x, y, width, height = rectangle
    return min(place[0] - x, x + width - place[0], place[1] - y, y + height - place[1])
