"""From the blocks of a run to its figures. Pure; milliseconds unless a name says otherwise."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from halo_service.evaluation.latency.blocks import Arrangement, Block
from halo_service.evaluation.latency.simulate import LatencyRecording, TrueContact
from halo_service.evaluation.latency.stopwatch import Row
from halo_service.geometry.surface import Surface
from halo_service.values import TouchEvent

SAME_PLACE_MM = 25.0
"""A down farther from a true contact belongs to another one (the paper's target, 5.2)."""
EARLY_US, LATE_US = 50_000, 150_000
"""A down belongs to a contact if it is sent this long before its beginning, or after it: a contact
of 100 ms and the frame in which it is noticed."""
MEDIAN_MS, P99_MS, RATIO, CONTACT_FRAMES = 5.0, 12.0, 5.0, 1.0
"""The goals."""


@dataclass(frozen=True, slots=True)
class Spread:
    """A few percentiles."""

    median: float
    p95: float
    p99: float
    largest: float


@dataclass(frozen=True, slots=True)
class Contacts:
    """From a true contact to its down message; an early one counts as 0 ms."""

    true: int
    reported: int
    early: int
    """Sent before their contact."""
    median_ms: float
    p95_ms: float
    median_frames: float


@dataclass(frozen=True, slots=True)
class Figures:
    """One arrangement over all its blocks."""

    frames: int
    """Sent."""
    dropped: int
    received: int
    """Different frames that arrived at the client."""
    datagrams: int
    latency: Spread
    """Received to sent."""
    stages: Mapping[str, Spread]
    cpu_a_frame: float
    """All threads."""
    path_cpu_a_frame: float
    """The thread from frame to packet alone."""
    core_wait_a_frame: float | None
    """How long that thread waited for a core, for other programs or our own threads; None where
    the system does not say."""
    hands: Spread | None
    """How much older than the frame its hands were, of the medians of each second; None where each
    frame waits for its own."""


@dataclass(frozen=True, slots=True)
class Goal:
    """One figure and its limit."""

    name: str
    value: float
    limit: str
    passed: bool


@dataclass(frozen=True, slots=True)
class Case:
    """Both arrangements over one recording."""

    source: str
    hands: int
    """How many the tracker looks for."""
    ours: Figures
    sequential: Figures
    contacts: Contacts | None
    """Of ours; None where the truth is unknown, or nothing touched. The paper's touch is not
    evaluated here, because its states were not measured with its own signal."""

    @property
    def ratio(self) -> float:
        """How many times lower our median is."""
        return self.sequential.latency.median / self.ours.latency.median


def case_of(
    recording: LatencyRecording, hands: int, blocks: Sequence[Block], surface: Surface
) -> Case:
    """Sum a run up."""

    def of(arrangement: Arrangement) -> list[Block]:
        return [block for block in blocks if block.arrangement == arrangement]

    delays_us = [
        delay_us
        for block in of("ours")
        for delay_us in _delays_us(recording.contacts or (), block.rows, surface)
    ]
    return Case(
        recording.name,
        hands,
        _figures(of("ours")),
        _figures(of("sequential")),
        _contacts(delays_us, 1e6 / recording.camera.fps),
    )


def goals(case: Case) -> tuple[Goal, ...]:
    """Compare a case with the goals."""
    latency, contacts = case.ours.latency, case.contacts
    found = [
        Goal("received -> sent, median", latency.median, f"<= {MEDIAN_MS:g} ms",
             latency.median <= MEDIAN_MS),
        Goal("received -> sent, p99", latency.p99, f"<= {P99_MS:g} ms", latency.p99 <= P99_MS),
        Goal("sequential order / ours, median", case.ratio, f">= {RATIO:g}", case.ratio >= RATIO),
    ]  # fmt: skip
    if contacts is not None:
        frames = contacts.median_frames
        found.append(
            Goal("contact -> down, median", frames, f"<= {CONTACT_FRAMES:g} frame",
                 frames <= CONTACT_FRAMES)
        )  # fmt: skip
    return tuple(found)


def _figures(blocks: Sequence[Block]) -> Figures:
    rows = [row for block in blocks for row in block.rows]
    names = dict.fromkeys(name for row in rows for name in row.stages_ns)
    hands_ms = [each for block in blocks for each in block.hands_ms]
    return Figures(
        frames=len(rows),
        dropped=sum(block.dropped for block in blocks),
        received=sum(block.received.frames - block.extra_packets for block in blocks),
        datagrams=sum(block.received.datagrams for block in blocks),
        latency=_percentiles([row.latency_ns / 1e6 for row in rows]),
        stages={
            name: _percentiles([row.stages_ns.get(name, 0) / 1e6 for row in rows]) for name in names
        },
        cpu_a_frame=sum(block.spent.cpu_ms for block in blocks) / len(rows),
        path_cpu_a_frame=sum(block.spent.path_cpu_ms for block in blocks) / len(rows),
        core_wait_a_frame=_a_frame([block.spent.core_wait_ms for block in blocks], len(rows)),
        hands=_percentiles(hands_ms) if hands_ms else None,
    )


def _percentiles(times_ms: Sequence[float]) -> Spread:
    median, p95, p99, largest = np.percentile(times_ms, (50, 95, 99, 100)).tolist()
    return Spread(median, p95, p99, largest)


def _a_frame(block_ms: Sequence[float | None], frames: int) -> float | None:
    known = [each for each in block_ms if each is not None]
    return sum(known) / frames if len(known) == len(block_ms) else None


def _contacts(delays_us: Sequence[float | None], period_us: float) -> Contacts | None:
    known = [each for each in delays_us if each is not None]
    if not known:
        return None
    early = sum(each < 0.0 for each in known)
    median, p95 = np.percentile(np.maximum(known, 0.0), (50, 95)).tolist()
    return Contacts(len(delays_us), len(known), early, median / 1e3, p95 / 1e3, median / period_us)


def _delays_us(
    contacts: Sequence[TrueContact], rows: Sequence[Row], surface: Surface
) -> list[float | None]:
    """Return for each true contact when its down was sent after it began, None where it was not.

    On the frames' clock: the frame's own time, and what passed from received to sent.
    """
    downs = [(row, event) for row in rows for event in row.events if event.kind == "down"]
    delays: list[float | None] = []
    for contact in contacts:
        index = next(
            (i for i, (row, event) in enumerate(downs) if _same(contact, row, event, surface)), None
        )
        if index is None:
            delays.append(None)
        else:
            row, _ = downs.pop(index)  # one down belongs to one contact
            delays.append(row.time_us - contact.from_us + row.latency_ns / 1e3)
    return delays


def _same(contact: TrueContact, row: Row, event: TouchEvent, surface: Surface) -> bool:
    if not -EARLY_US <= row.time_us - contact.from_us <= LATE_US:
        return False
    x, y, _ = surface.from_camera(np.array([contact.camera_mm]))[0]
    return math.hypot(event.x_mm - x, event.y_mm - y) <= SAME_PLACE_MM
