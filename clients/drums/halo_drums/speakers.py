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

from halo_drums.mixer import Mixer
from halo_drums.player import Gesture
from halo_drums.quiet import quiet
from halo_drums.voices import RATE

PERIOD_MS = 5
"""What the device asks for at once: as near to a block as whole milliseconds come."""
PERIODS = 4
"""Periods that the device keeps ready; later than all of them, there is a gap."""
LATENCY_S = PERIODS * PERIOD_MS / 1000
"""What a hit waits at most for the sound before it."""
SWITCH_S = 0.0005
"""Python hands over between threads so often, not every 5 ms: that would be a whole block."""


class SoundError(Exception):
    """No sound can be made. The message is meant for the user."""


class Speakers:
    """A stream that plays. A context manager; `SoundError` where there is no device."""

    def __init__(self, mixer: Mixer, backends: Sequence[miniaudio.Backend] = ()) -> None:
        self._mixer = mixer
        self._gestures: queue.SimpleQueue[Gesture] = queue.SimpleQueue()
        self._ready = np.zeros((0, 2), np.float32)
        self._began_s: float | None = None
        self._played = 0
        self.made_s = 0.0
        """Sound that the device has asked for."""
        self.gaps = 0
        """Times that the device had nothing to play."""
        self.latest_s = 0.0
        """Longest time that a piece came late; past `LATENCY_S` there is a gap."""
        self.slowest = 0.0
        """Longest time that making a piece of sound took, over the time that it plays."""
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
            raise SoundError(_no_device(str(error.args[0]))) from error
        if self._device.backend == "Null" and miniaudio.Backend.NULL not in backends:
            self._device.close()
            raise SoundError(_no_device("none was found"))
        sys.setswitchinterval(SWITCH_S)
        # Looking through all that was loaded takes the collector longer than a block lasts.
        gc.collect()
        gc.freeze()
        stream = self._stream()
        next(stream)
        self._device.start(stream)

    def send(self, gesture: Gesture) -> None:
        """Let a gesture be heard as soon as can be. From any thread."""
        self._gestures.put(gesture)

    def close(self) -> None:
        """End the sound. May be called twice."""
        self._device.close()

    def _stream(self) -> Generator[NDArray[np.float32], int, None]:
        wanted = yield np.zeros((0, 2), np.float32)
        while True:
            began_s = time.perf_counter()
            self._listen()
            while len(self._ready) < wanted:
                self._ready = np.concatenate([self._ready, self._mixer.block()])
            piece, self._ready = self._ready[:wanted], self._ready[wanted:]
            self._count(wanted, began_s, time.perf_counter())
            wanted = yield piece

    def _listen(self) -> None:
        while True:
            try:
                self._mixer.take(self._gestures.get_nowait())
            except queue.Empty:
                return

    def _count(self, samples: int, began_s: float, now_s: float) -> None:
        """Compare what was made with what has been played by now."""
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


def _no_device(why: str) -> str:
    return (
        f"no sound device ({why}); plug one in, or play a sampler with --midi, "
        "or make a file of a recorded stream with --render OUT.wav"
    )
