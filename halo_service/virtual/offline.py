"""A scenario as recordings want it: every frame at full quality, as fast as it can be drawn."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np

from halo_service.errors import UserError
from halo_service.values import Frame
from halo_service.virtual import truth
from halo_service.virtual.clock import clocks_of
from halo_service.virtual.installation.interference import shares
from halo_service.virtual.scenarios import ENDING, start_scenario
from halo_service.virtual.sensor import Sensor
from halo_service.virtual.sim_url import SimRequest

JITTER_S = 0.0007
"""Of the timestamps of a single camera, one sigma; chosen. Cameras of an installation are never
late: their delays are shorter than this."""
LONGEST_S = 600.0
"""A scenario that should end by itself has by then."""


class SimulatedRecording:
    """One recording of a scenario. Iterate once; then ask for the script.

    Timestamps are whole milliseconds, as Matroska keeps them, so that frames and truth agree
    after reading back. Raises UserError for a length that cannot be.
    """

    def __init__(
        self,
        request: SimRequest,
        seconds: float | None = None,
        *,
        colour: bool = True,
        colour_times: int = 1,
        start_s: float = 0.0,
        whole_ms: bool = True,
    ) -> None:
        """`colour_times`: see `Sensor`; 2 is what a live virtual camera shows.

        `start_s`: frames before it are neither rendered nor returned. `whole_ms`: of timestamps;
        False: whole microseconds, as the device has them.
        """
        if seconds is None and request.scenario not in ENDING:
            raise UserError(
                f"The scenario {request.scenario!r} never ends by itself; give its length in s."
            )
        if seconds is not None and not 0.0 < seconds < 1e6:
            raise UserError(f"A recording cannot be {seconds:g} s long; give more than 0.")
        fps = request.room.camera().fps
        self.expected_frames = None if seconds is None else round(seconds * fps)
        """None where the scenario itself decides."""
        self._first = round(start_s * fps)
        self._room = request.room
        self._step_us = 1000 if whole_ms else 1
        self._scenario = start_scenario(request.scenario, request.room)
        self._jitter_s = JITTER_S if request.room.installation.alone else 0.0
        times = colour_times if colour else 0
        self._other_clocks = clocks_of(request.room, request.scenario)
        self.clock = self._other_clocks.pop(request.room.installation.camera)
        self._sensor = Sensor(request.room, colour_times=times, started_us=self.clock.start_us)
        self.camera, self.surface = self._sensor.camera, self._sensor.surface

    def __iter__(self) -> Iterator[tuple[Frame | None, list[truth.Line]]]:
        """Each frame with its lines of truth.

        The frame is None where the device dropped it: no frame, no line of its own, but touches
        that ended meanwhile are still reported.
        """
        rng = np.random.default_rng([*self._room.noise_seed, 3])
        for index in range(self.expected_frames or round(LONGEST_S * self.camera.fps)):
            late_s = abs(rng.normal(0.0, self._jitter_s)) if index else 0.0
            dropped = index > 0 and rng.random() < self._room.drop
            if index < self._first:
                continue
            exposed_us = self.clock.device_us(self.clock.exposed_s(index) + late_s)
            time_us = round(exposed_us / self._step_us) * self._step_us
            light = shares(self.clock, self._other_clocks, index)
            yield self._capture(time_us, dropped or self.clock.skips(index), light)
            if self.expected_frames is None and self._scenario.finished:
                return

    def _capture(
        self, time_us: int, dropped: bool, shared_light: Mapping[int, float]
    ) -> tuple[Frame | None, list[truth.Line]]:
        t_s = self.clock.host_s(time_us)
        snapshot = self._scenario.at(t_s)
        lines = [
            truth.contact_line(contact, self.surface, self.clock.device_us)
            for contact in self._scenario.ended_contacts(t_s)
        ]
        if dropped:
            return None, lines
        lines.append(truth.frame_line(time_us, self.camera, self.surface, snapshot.hands))
        frame = self._sensor.frame(time_us, snapshot.hands, snapshot.things, shared_light)
        return frame, lines

    def script(self) -> list[truth.Line]:
        """The steps so far, in seconds from the first frame."""
        return [truth.step_line(step, self.clock.frame_s) for step in self._scenario.steps]


def frames(
    request: SimRequest, seconds: float | None = None, *, colour: bool = True
) -> Iterator[tuple[Frame | None, list[truth.Line]]]:
    """What a `SimulatedRecording` yields, for those who need no script."""
    return iter(SimulatedRecording(request, seconds, colour=colour))
