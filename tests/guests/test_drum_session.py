"""The virtual drumming session, sensed by the service, heard as drums."""

from __future__ import annotations

import random
from collections.abc import Callable
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import halo_client
from halo_client import FileSource
from halo_drums.player import Hit, Player
from halo_drums.render import TAIL_S, render
from halo_drums.voices import RATE
from halo_protocol import Assembler, TouchFrame
from halo_service.outputs.wire import Wire

SECONDS = 7.5
HOP, WIDTH, BACK = 48, 240, 6
"""A look each millisecond, over 5 ms, compared with that of 6 ms before."""
ONSET = 5.0
"""Decades of power, summed over seven octaves, that make an onset. Ringing drums stay below 4.5,
the weakest hits are above 6."""


def onsets_s(sound: NDArray[np.float32]) -> list[float]:
    """When something begins to sound: where the spectrum rises in many octaves at once."""
    mono = sound.mean(axis=1).astype(float)
    views = np.lib.stride_tricks.sliding_window_view(mono, WIDTH)[::HOP] * np.hanning(WIDTH)
    power = np.abs(np.fft.rfft(views, axis=1)) ** 2
    edges = [0, 2, 4, 8, 16, 32, 64, 121]
    octaves = np.stack([power[:, a:b].sum(axis=1) for a, b in pairwise(edges)], axis=1)
    level = np.log10(octaves + 1e-4)
    rise = np.zeros(len(level))
    rise[BACK:] = np.maximum(0.0, level[BACK:] - level[:-BACK]).sum(axis=1)
    found: list[float] = []
    for at in np.flatnonzero(rise > ONSET):
        window = rise[max(0, at - 25) : at + 25]
        if rise[at] == window.max():
            found.append((at * HOP + WIDTH / 2) / RATE)
    return found


@pytest.mark.slow
def test_each_hit_of_the_session_is_heard_once_within_5_ms(
    sensed: Callable[[str, float], Any],
) -> None:
    session = sensed("sim:drumming?seed=3", SECONDS)
    frames = list(halo_client.frames(FileSource(session.stream, paced=False)))
    sound = render(frames)
    downs_s = [
        (frame.time_us - frames[0].time_us) / 1e6 - down.ago_ms / 1e3
        for frame in frames
        for down in frame.downs
    ]
    heard_s = onsets_s(sound)
    errors_ms = [1e3 * min(abs(at - down) for at in heard_s) for down in downs_s]
    true = sum("contact" in line for line in session.truth)
    print(f"{len(downs_s)} downs ({true} true touches), {len(heard_s)} onsets")
    print(f"off by at most {max(errors_ms):.1f} ms; peak {np.abs(sound).max():.2f}")
    assert len(downs_s) >= 6
    assert len(heard_s) == len(downs_s)
    assert max(errors_ms) < 5.0
    assert np.abs(sound).max() < 1.0
    assert np.abs(sound[-round(0.1 * RATE) :]).max() < 0.01, "it rings out"
    assert len(sound) > TAIL_S * RATE


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(5))
def test_with_a_fifth_of_the_datagrams_lost_still_one_sound_a_hit(
    sensed: Callable[[str, float], Any], seed: int
) -> None:
    session = sensed("sim:drumming?seed=3", SECONDS)

    def hits(loss: float) -> list[tuple[int, Hit]]:
        lost, wire, assembler, player = (
            random.Random(seed),
            Wire("sim", "s1", 0),
            Assembler(),
            Player(),
        )
        found = []
        for number, told in enumerate(session.told):
            for datagram in wire.frame(told):
                # One that has just joined hears of no hit that was before: it has joined.
                if number and lost.random() < loss:
                    continue
                for event in assembler.receive_data(datagram, told.time_us / 1e6):
                    if isinstance(event, TouchFrame):
                        gestures = player.take(event)
                        found += [(event.frame, hit) for hit in gestures if isinstance(hit, Hit)]
        return found

    whole, holed = hits(0.0), hits(0.2)
    late = {hit.key: arrived for arrived, hit in holed}
    assert len(late) == len(holed), "none is heard twice"
    assert [hit.key for _, hit in whole] == [hit.key for _, hit in holed]
    delays = [late[hit.key] - arrived for arrived, hit in whole]
    print("frames late:", delays)
    assert all(0 <= delay <= 6 for delay in delays)
