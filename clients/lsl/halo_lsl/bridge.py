"""From the events of a receiver to the outlets.

Rule: no clock and no socket of its own: times and outlets are arguments. The streams are created
when the service has described itself, so that their description is complete.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from statistics import median
from typing import Protocol

from halo_client.picture import HEIGHT_MM, WIDTH_MM
from halo_lsl.clock import Arrival, Clock
from halo_lsl.samples import Regular, contact_samples
from halo_lsl.streams import CONTACTS, MARKERS, POINTERS, Setup, Stream
from halo_protocol import Event, Health, Lost, Report, Scene, TouchFrame

DEFAULT_RATE_HZ = 30.0
PATIENCE = 45
"""Frames without a scene or health, after which the streams are created without one."""
FEWEST = 15
"""Frames before the streams are created, to measure the delay of the pipeline."""


class Output(Protocol):
    """The outlets, or their substitute in a test."""

    def push(self, stream: Stream, values: Sequence[float | str], time_s: float) -> None:
        """Send a sample."""


class Bridge:
    """Remembers the service and what it needs to send on."""

    def __init__(self, clock: Clock, create: Callable[[Setup], Output]) -> None:
        """`create` makes the outlets."""
        self._clock, self._create = clock, create
        self._output: Output | None = None
        self._scene: Scene | None = None
        self._session = ""
        self._announced = False
        self._delays_s: list[float] = []
        self._regular = Regular(DEFAULT_RATE_HZ)

    @property
    def created(self) -> bool:
        """Whether the streams exist."""
        return self._output is not None

    def process(self, event: Event, now: Arrival) -> None:
        """Process an event of the service that is followed."""
        if isinstance(event, TouchFrame):
            self._frame(event, now)
        elif isinstance(event, Report) and isinstance(event.message, Scene):
            self._describe(event.message, now)
        elif isinstance(event, Report) and isinstance(event.message, Health):
            self._clock.report(event.message.clock_error_ms / 1e3)
        elif isinstance(event, Lost):
            self._mark(f"service/lost/{event.node}", now.lsl_s)

    def _frame(self, frame: TouchFrame, now: Arrival) -> None:
        if frame.session != self._session:
            if self._session:
                self._clock.restart()
            self._session, self._announced = frame.session, False
        frame_s = frame.time_us / 1e6
        self._clock.read(frame_s, now)
        if self._output is None:
            self._wait(frame, now)
        if self._output is None:
            return
        if not self._announced:
            self._mark(f"service/session/{frame.session}", self._clock.to_lsl(frame_s))
            self._announced = True
        self._push(frame, self._output)

    def _wait(self, frame: TouchFrame, now: Arrival) -> None:
        """Create the streams once everything for their description has arrived."""
        self._delays_s.append(self._clock.pipeline_s)
        count = len(self._delays_s)
        described = self._scene is not None and self._clock.reported
        if count < FEWEST or (count < PATIENCE and not described):
            return
        rate_hz = DEFAULT_RATE_HZ if self._scene is None else self._scene.rate_hz
        rate_hz = rate_hz or DEFAULT_RATE_HZ
        delay_s = median(self._delays_s)
        setup = Setup(
            frame.node,
            frame.surface,
            self._scene,
            rate_hz,
            self._clock.kind or self._clock.wanted,
            delay_s,
            now.unix_s,
        )
        self._regular = Regular(rate_hz)
        self._output = self._create(setup)

    def _push(self, frame: TouchFrame, output: Output) -> None:
        for sample in self._regular.samples(frame, self._clock.to_lsl(frame.time_us / 1e6)):
            output.push(POINTERS, sample.values, sample.time_s)
        size_mm = (WIDTH_MM, HEIGHT_MM)
        if self._scene is not None:
            size_mm = (self._scene.width_mm, self._scene.height_mm)
        for contact, marker in contact_samples(frame, size_mm, self._clock.to_lsl):
            output.push(CONTACTS, contact.values, contact.time_s)
            output.push(MARKERS, (marker.text,), marker.time_s)

    def _describe(self, scene: Scene, now: Arrival) -> None:
        before, self._scene = self._scene, scene
        if before is not None and scene.revision != before.revision:
            self._mark(f"calibration/revision/{scene.revision}", now.lsl_s)

    def _mark(self, text: str, time_s: float) -> None:
        if self._output is not None:
            self._output.push(MARKERS, (text,), time_s)
