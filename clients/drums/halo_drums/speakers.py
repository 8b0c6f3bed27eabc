"""The mixer on a sound device.

Rule: the device and nothing else. Gestures go through one queue to the thread that makes sound;
the mixer belongs to that thread alone.
"""

from __future__ import annotations

import gc
import queue
import sys
import time
from collections.abc import Generator, Sequence
from typing import Self

import miniaudio
import numpy as np
from numpy.typing import NDArray

from halo_client.quiet import quiet
from halo_drums.errors import SoundError
from halo_drums.mixer import Mixer
from halo_drums.player import Gesture
from halo_drums.voices import RATE

PERIOD_MS = 5
"""Length of one device period: the whole number of ms nearest to a block."""
PERIODS = 4
"""Periods that the device buffers; a later block leaves a gap."""
LATENCY_S = PERIODS * PERIOD_MS / 1000
"""Longest time that a hit waits for buffered sound."""
SWITCH_S = 0.0005
"""Python's thread switch interval; its default of 5 ms is a whole block."""
REMEDY = (
    "plug one in, try --silent, use a sampler with --midi PORT, or write a recorded stream to a "
    "file with --render OUT.wav"
)


class Speakers:
    """An open sound stream; a context manager. Raises `SoundError` without a device."""

    def __init__(
        self,
        mixer: Mixer,
        backends: Sequence[miniaudio.Backend] = (),
        remedy: str = REMEDY,
    ) -> None:
        self._mixer = mixer
        self._gestures: queue.SimpleQueue[Gesture] = queue.SimpleQueue()
        self._ready = np.zeros((0, 2), np.float32)
        self._began_s: float | None = None
        self._played = 0
        self.made_s = 0.0
        """Seconds of sound that the device has requested."""
        self.gaps = 0
        """Number of times that the device had nothing to play."""
        self.latest_s = 0.0
        """Longest delay of a piece; above `LATENCY_S` there is a gap."""
        self.slowest = 0.0
        """Longest ratio of computing time to playing time of a piece."""
        try:
            with quiet():
                self._device = miniaudio.PlaybackDevice(
                    output_format=miniaudio.SampleFormat.FLOAT32,
                    nchannels=2,
                    sample_rate=RATE,
                    buffersize_msec=PERIOD_MS,
                    callback_periods=PERIODS,
                    backends=list(backends),
                    app_name="halo-drums",
                )
        except miniaudio.MiniaudioError as error:
            raise SoundError(f"no sound device ({error.args[0]}); {remedy}") from error
        if self._device.backend == "Null" and miniaudio.Backend.NULL not in backends:
            self._device.close()
            raise SoundError(f"no sound device (none was found); {remedy}")
        sys.setswitchinterval(SWITCH_S)
        # A full garbage collection takes longer than a block; exclude what is loaded by now.
        gc.collect()
        gc.freeze()
        stream = self._stream()
        next(stream)
        self._device.start(stream)

    def send(self, gesture: Gesture) -> None:
        """Queue a gesture for the next block. Thread-safe."""
        self._gestures.put(gesture)

    def close(self) -> None:
        """Stop the sound. May be called twice."""
        self._device.close()

    def _stream(self) -> Generator[NDArray[np.float32], int, None]:
        requested = yield np.zeros((0, 2), np.float32)
        while True:
            began_s = time.perf_counter()
            self._apply_queued()
            while len(self._ready) < requested:
                self._ready = np.concatenate([self._ready, self._mixer.block()])
            piece, self._ready = self._ready[:requested], self._ready[requested:]
            self._count(requested, began_s, time.perf_counter())
            requested = yield piece

    def _apply_queued(self) -> None:
        while True:
            try:
                self._mixer.apply(self._gestures.get_nowait())
            except queue.Empty:
                return

    def _count(self, samples: int, began_s: float, now_s: float) -> None:
        """Compare the sound delivered with the time passed; count gaps."""
        self._began_s = began_s if self._began_s is None else self._began_s
        self._played += samples
        self.made_s += samples / RATE
        self.slowest = max(self.slowest, (now_s - began_s) * RATE / samples)
        behind_s = now_s - self._began_s - self._played / RATE
        self.latest_s = max(self.latest_s, behind_s)
        if behind_s > LATENCY_S:
            self.gaps += 1
            self._began_s, self._played = now_s, 0

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()
