"""The monitor's picture, as lines of text.

Rule: pure. Events and times in, lines out; no printing, no clock.
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass, field
from statistics import median

from halo_client import KnownServices, Losses, waiting
from halo_protocol import (
    VERSION,
    Calibration,
    Camera,
    Down,
    Event,
    Finger,
    Hand,
    Health,
    Load,
    Lost,
    Pointer,
    ProfileFit,
    Scene,
    Source,
    State,
    TouchFrame,
    Tracker,
    Up,
)

_WINDOW_S = 1.0
"""Rates and latencies cover the last second."""
_EVENTS = 6
"""Number of touches shown."""
_BELIEVABLE_US = 60_000_000
"""A frame further from now than this has a recording's time, so its latency is unknown."""

LOUD = {
    Source.VIRTUAL: "!! VIRTUAL CAMERA: no real camera looks at a real hand !!",
    Source.RECORDING: "!! RECORDING: what you see happened earlier !!",
}
"""Warnings if the source is not a camera."""

LOADS = {
    Load.REDUCED: "new fingers appear a little later",
    Load.LEAST: "new fingers appear later",
    Load.DROPPING: "new fingers appear later, and camera frames are left out",
}
MISFITS = {
    ProfileFit.MOVED: "the surface was moved since the calibration",
    ProfileFit.TILTED: "camera or table was tilted since the calibration",
    ProfileFit.HIDDEN: "the surface is covered, or this is another place",
    ProfileFit.MARKER: "the printed marker is not at its place",
}
"""Why the profile does not fit."""
SLOW = 0.9
"""A service that senses a smaller share of the camera's frames loses touches."""

# 80 columns, so that it fits the smallest terminal.
HEADINGS = "   id slot hand    finger state    x mm    y mm  hov mm  press  grams  conf hits"


@dataclass(slots=True)
class _Stream:
    """One session on one surface."""

    frame: TouchFrame
    arrivals_s: deque[float] = field(default_factory=deque)
    latencies_ms: deque[float | None] = field(default_factory=deque)
    missed: int = 0
    events: deque[str] = field(default_factory=lambda: deque(maxlen=_EVENTS))


class View:
    """State of the picture. Bounded: a stream is removed when its service is lost."""

    def __init__(self) -> None:
        self._streams: dict[tuple[str, str, str], _Stream] = {}

    def update(self, event: Event, now_s: float, unix_us: int) -> None:
        """Take in an event that arrived at `now_s` and at this Unix time."""
        if isinstance(event, TouchFrame):
            self._add_frame(event, now_s, unix_us)
        elif isinstance(event, Lost):
            self._streams.pop((event.node, event.surface, event.session), None)

    def lines(self, url: str, known: KnownServices, losses: Losses, now_s: float) -> list[str]:
        """Return the picture as lines."""
        head = f"halo monitor · {url} · protocol {VERSION}"
        drops = sum(health.drops for health in known.healths.values())
        lost = (
            f"lost frames: {drops} in the service, {losses.missed} on the way, "
            f"{losses.incomplete} in part · late or twice {losses.dropped} · bad {losses.bad}"
        )
        lines = [head, lost]
        for stream in self._streams.values():
            lines += ["", *_stream_lines(stream, known, now_s)]
        if not self._streams:
            lines += ["", *_scene_lines(known), waiting(url)]
        return lines

    def _add_frame(self, frame: TouchFrame, now_s: float, unix_us: int) -> None:
        key = (frame.node, frame.surface, frame.session)
        stream = self._streams.setdefault(key, _Stream(frame))
        stream.frame = frame
        stream.missed += frame.missed
        stream.arrivals_s.append(now_s)
        stream.latencies_ms.append(latency_ms(frame, unix_us))
        while stream.arrivals_s[0] < now_s - _WINDOW_S:
            stream.arrivals_s.popleft()
            stream.latencies_ms.popleft()
        stream.events += [_event_words(event) for event in frame.events]


def latency_ms(frame: TouchFrame, unix_us: int) -> float | None:
    """Time from the frame to its arrival; None if the frame's time is not this clock's."""
    age_us = unix_us - frame.time_us
    return age_us / 1000 if abs(age_us) < _BELIEVABLE_US else None


def _stream_lines(stream: _Stream, known: KnownServices, now_s: float) -> list[str]:
    frame = stream.frame
    where = (frame.node, frame.surface)
    rate_hz = sum(at_s > now_s - _WINDOW_S for at_s in stream.arrivals_s) / _WINDOW_S
    lines = [f"{frame.node}/{frame.surface} · session {frame.session}"]
    if where in known.scenes:
        lines += _scene(known.scenes[where])
    lines.append(
        f"  frame {frame.frame} · {rate_hz:.0f} a second · latency {_latency(stream)} · "
        f"lost {stream.missed}"
    )
    if where in known.healths:
        health = known.healths[where]
        lines += [
            f"  service {health.fps:.1f} fps, {_ms(health.latency_ms)} a frame · "
            f"drops {health.drops}, bad frames {health.bad_frames}",
            *_warnings(health, known.scenes.get(where)),
            f"  camera {_word(Camera, health.camera)} · "
            f"hand tracker {_word(Tracker, health.tracker)}, {_ms(health.tracker_ms)} old"
            f"{_looks(health)}",
            *_canvas(health),
        ]
    lines += [HEADINGS, *map(_pointer_line, frame.pointers)]
    if not frame.pointers:
        lines.append("    - no finger near the surface")
    return [*lines, f"  touches: {' · '.join(reversed(stream.events)) or '-'}"]


def _looks(health: Health) -> str:
    return f", looks {health.looks_hz:.0f} times a second" if health.looks_hz >= 0.0 else ""


def _canvas(health: Health) -> list[str]:
    if not health.nodes:
        return []
    clocks = f"clocks up to {abs(health.clock_offset_ms):.1f} ms off"
    return [
        f"  canvas of {health.nodes} surfaces · {clocks} (+- {health.clock_deviation_ms:.1f} ms)"
    ]


def _warnings(health: Health, scene: Scene | None) -> list[str]:
    """Return what is wrong although frames come."""
    lines = []
    rate_hz = scene.rate_hz if scene and health.camera == Camera.RUNNING else 0.0
    if 0.0 < health.fps < SLOW * rate_hz:
        lines.append(f"  !! SLOW: the service senses {health.fps:.0f} of {rate_hz:.0f} Hz !!")
    if health.load in LOADS:
        lines.append(f"  !! BUSY MACHINE: {LOADS[Load(health.load)]} !!")
    if health.profile_fit in MISFITS:
        reason = MISFITS[ProfileFit(health.profile_fit)]
        lines.append(f"  !! PROFILE DOES NOT FIT: {reason} !!")
    if health.zenoh_missing > 0:
        lines.append(f"  !! ZENOH: {health.zenoh_missing} of its routers or peers are away !!")
    if health.write_errors > 0:
        lines.append("  !! NOT SAVED: the service could not write its profile; see its log !!")
    return lines


def _scene_lines(known: KnownServices) -> list[str]:
    lines = []
    for (node, surface), scene in known.scenes.items():
        lines += [f"{node}/{surface} · session {scene.session}", *_scene(scene)]
    return lines


def _scene(scene: Scene) -> list[str]:
    about = (
        f"  source {_word(Source, scene.source)} at {scene.rate_hz:.0f} Hz · "
        f"{scene.width_mm:.0f} x {scene.height_mm:.0f} mm · "
        f"calibration {_word(Calibration, scene.calibration)} (revision {scene.revision})"
    )
    loud = [f"  {text}" for source, text in LOUD.items() if scene.source == source]
    other = scene.version.split(".")[:2] != VERSION.split(".")[:2]
    return [*loud, about, *([f"  its protocol is {scene.version}"] if other else [])]


def _pointer_line(pointer: Pointer) -> str:
    force = "-" if pointer.force_g < 0 else f"{pointer.force_g:.0f}"
    state = _word(State, pointer.state)
    return (
        f"{pointer.id:5d} {pointer.slot:4d} {_word(Hand, pointer.hand):7} "
        f"{_word(Finger, pointer.finger):6} {state.upper() if pointer.touching else state:5} "
        f"{pointer.x_mm:7.1f} {pointer.y_mm:7.1f} {pointer.hover_mm:7.1f} "
        f"{pointer.pressure:6.2f} {force:>6} {pointer.confidence:5.2f} {pointer.contacts:4d}"
    )


def _event_words(event: Down | Up) -> str:
    if isinstance(event, Down):
        strike = "lost" if event.strike_mm_s < 0 else f"{event.strike_mm_s:.0f} mm/s"
        return f"down {event.id}#{event.contacts} ({strike})"
    return f"up {event.id}#{event.contacts}"


def _latency(stream: _Stream) -> str:
    values = [value for value in stream.latencies_ms if value is not None]
    if not values:
        return "- (a recording's time)"
    return f"{median(values):.1f} ms, at most {max(values):.1f}"


def _ms(value_ms: float) -> str:
    return "-" if value_ms < 0 else f"{value_ms:.1f} ms"


def _word(
    words: type[State | Hand | Finger | Source | Calibration | Camera | Tracker], n: int
) -> str:
    """Return the enumeration's word, or the number if this version does not know it."""
    return words(n).name.lower() if n in set(words) else str(n)
