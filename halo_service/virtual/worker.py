"""The other side of the live virtual camera: a process that draws at its camera's rate.

Rule: it owns the clock and the pace, nothing else does. It waits on its pipe between frames, so
it answers at once, and it ends when the pipe does: with its parent, whatever becomes of that.
"""

from __future__ import annotations

import json
import logging
import os
import signal
from collections.abc import Mapping
from contextlib import nullcontext
from multiprocessing.connection import Connection
from multiprocessing.shared_memory import SharedMemory
from pathlib import Path
from typing import Any, TextIO

# One thread each: the service needs the other core.
os.environ.setdefault("OMP_NUM_THREADS", "1")

import cv2  # after the environment above
import numpy as np

from halo_service import host_clock
from halo_service.errors import UserError
from halo_service.host_clock import CLOCK
from halo_service.virtual import truth
from halo_service.virtual.camera import factory
from halo_service.virtual.clock import clocks_of
from halo_service.virtual.installation.interference import shares
from halo_service.virtual.ring import Ring
from halo_service.virtual.scenarios import start_scenario
from halo_service.virtual.sensor import Sensor
from halo_service.virtual.sim_url import SimRequest

JITTER_S = 0.0007
"""Of a single camera's exposures, one sigma; chosen."""
LIVE_COLOUR_TIMES = 2
"""Live, colour is drawn at half its size each way."""


def run(
    pipe: Connection,
    memory_name: str,
    request: SimRequest,
    colour: bool,
    truth_path: str | None,
) -> None:
    """Scenario a scenario for ever, or until the pipe closes."""
    # Ctrl-C reaches the whole process group; the parent ends this process.
    for name in ("SIGINT", "SIGTERM", "SIGHUP"):
        if hasattr(signal, name):
            signal.signal(getattr(signal, name), signal.SIG_IGN)
    # The service notices a set clock itself, and logs it.
    logging.getLogger(host_clock.__name__).setLevel(logging.ERROR)
    cv2.setNumThreads(1)
    memory = SharedMemory(memory_name)
    camera = factory(request.room.device, request.room.mode)
    ring = Ring(memory, camera.depth)
    try:
        with Path(truth_path).open("w") if truth_path else nullcontext() as log:
            _Camera(pipe, ring, request, colour, log).run()
    except (EOFError, BrokenPipeError, ConnectionResetError):
        pass  # the parent has gone: the normal end
    except UserError as error:
        pipe.send(("failed", str(error)))
    except Exception as error:
        pipe.send(("failed", f"The virtual camera stopped: {type(error).__name__}: {error}."))
        raise
    finally:
        ring.release()
        memory.close()


class _Camera:
    """The device: exposes, draws and hands over one frame after the other."""

    def __init__(
        self,
        pipe: Connection,
        ring: Ring,
        request: SimRequest,
        colour: bool,
        log: TextIO | None,
    ) -> None:
        self._pipe, self._ring, self._log = pipe, ring, log
        self._drop = request.room.drop
        self._rng = np.random.default_rng([*request.room.noise_seed, 3])
        self._scenario = start_scenario(request.scenario, request.room)
        switched_on_us = CLOCK.unix_us()
        self._sensor = Sensor(
            request.room,
            colour_times=LIVE_COLOUR_TIMES if colour else 0,
            started_us=switched_on_us,
            live=True,
        )
        # Once for nothing, so that what is built at first use does not hold up a frame.
        joins = not request.room.installation.alone
        snapshot = self._scenario.at(CLOCK.unix_us() / 1e6 if joins else 0.0)
        self._sensor.frame(switched_on_us, snapshot.hands, snapshot.things)
        # Live, frames carry Unix time: drift and start of the device's clock are mapped already.
        self._other_clocks = clocks_of(request.room, request.scenario)
        self._clock = self._other_clocks.pop(request.room.installation.camera)
        # Cameras of an installation show the same moment: their time 0 is that of Unix.
        self._start_us = 0 if joins else CLOCK.unix_us()
        self._jitter_s = 0.0 if joins else JITTER_S
        self._number = 0
        self._asked: int | None = None
        """The newest frame that the reader has, while it waits for a newer one."""

    def run(self) -> None:
        """Until the pipe breaks; nothing is drawn before somebody wants a frame."""
        while self._asked is None:
            self._obey(*self._pipe.recv())
        index = -1
        while True:
            elapsed_s = (CLOCK.unix_us() - self._start_us) / 1e6
            # Late: leave frames out, never catch up.
            index = max(index + 1, int((elapsed_s - self._clock.first_s) * self._clock.fps))
            due_s = self._clock.exposed_s(index) + abs(self._rng.normal(0.0, self._jitter_s))
            lost = self._clock.skips(index) or self._rng.random() < self._drop
            light = shares(self._clock, self._other_clocks, index)
            self._expose(self._start_us + round(due_s * 1e6), lost, light)

    def _unix_us(self, t_s: float) -> int:
        return self._start_us + round(t_s * 1e6)

    def _expose(self, time_us: int, lost: bool, shared_light: Mapping[int, float]) -> None:
        self._serve_until(time_us / 1e6)
        t_s = (time_us - self._start_us) / 1e6
        snapshot = self._scenario.at(t_s)
        surface = self._sensor.surface
        lines = [
            truth.contact_line(contact, surface, self._unix_us)
            for contact in self._scenario.ended_contacts(t_s)
        ]
        if not lost:
            frame = self._sensor.frame(time_us, snapshot.hands, snapshot.things, shared_light)
            self._number += 1
            self._ring.write(self._number, frame)
            lines.append(truth.frame_line(time_us, self._sensor.camera, surface, snapshot.hands))
        if self._log is not None:
            self._log.writelines(json.dumps(line) + "\n" for line in lines)
            self._log.flush()

    def _serve_until(self, due_s: float) -> None:
        """Answer the reader until it is time."""
        while True:
            if self._asked is not None and self._number > self._asked:
                self._pipe.send(("new", self._number))
                self._asked = None
            if not self._pipe.poll(max(0.0, due_s - CLOCK.unix_us() / 1e6)):
                return
            self._obey(*self._pipe.recv())

    def _obey(self, kind: str, value: Any) -> None:
        """Do what the reader asks for."""
        if kind == "next":
            self._asked = value
        elif kind == "show":
            self._sensor.show(value)
        elif kind == "colour":
            self._sensor.with_colour(value)
        else:
            self._scenario.send(value)
