"""Virtual drumming, sensed by the service and rendered as sound."""

from __future__ import annotations

import random
from collections.abc import Callable
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import halo_client
from halo_client import FileSource, TouchKey
from halo_drums.bank import make_bank
from halo_drums.kit import KIT, Settings, pad_at
from halo_drums.mixer import Mixer
from halo_drums.player import Hit, Player, Shape
from halo_drums.render import TAIL_S, render
from halo_drums.voices import RATE
from halo_protocol import Assembler, TouchFrame
from halo_service.outputs.frame_encoder import FrameEncoder
from tests.kind_sensor import KIND_URL

SECONDS = 7.5
SESSIONS = (f"sim:drumming?seed=4&{KIND_URL}", f"sim:drumming?seed=5&{KIND_URL}")
"""The onset detector was tuned on seed 3, and is tested on other seeds."""
STEP_MM = 5.0
"""Heights in steps of this size are averaged."""
HOP, WIDTH, BACK = 48, 240, 6
"""Spectra of 5 ms, one per ms, compared with the one 6 ms earlier; samples."""
ONSET = 5.0
"""Rise of power in decades, summed over seven octaves, that counts as an onset. Decaying drums stay
below 4.5, the weakest hits exceed 6."""


def find_onsets_s(sound: NDArray[np.float32]) -> list[float]:
    """Times at which the spectrum rises in many octaves at once."""
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
@pytest.mark.parametrize("name", SESSIONS)
def test_each_touch_sounds_once_within_5_ms(sensed: Callable[[str, float], Any], name: str) -> None:
    session = sensed(name, SECONDS)
    frames = list(halo_client.frames(FileSource(session.stream, paced=False)))
    sound = render(frames)
    downs_s = [
        (frame.time_us - frames[0].time_us) / 1e6 - down.ago_ms / 1e3
        for frame in frames
        for down in frame.downs
    ]
    onset_s = find_onsets_s(sound)
    errors_ms = [1e3 * min(abs(at - down) for at in onset_s) for down in downs_s]
    true = sum("contact" in line for line in session.truth)
    *_, last = (line["fingers"] for line in session.truth if "fingers" in line)
    true += sum(each["touching"] for each in last)  # the truth lists a contact at its end
    print(f"{len(downs_s)} downs ({true} true touches), {len(onset_s)} onsets")
    print(f"off by at most {max(errors_ms):.1f} ms; peak {np.abs(sound).max():.2f}")
    assert len(downs_s) == true >= 6
    assert len(onset_s) == len(downs_s)
    assert max(errors_ms) < 5.0
    assert np.abs(sound).max() < 1.0
    assert np.abs(sound[-round(0.1 * RATE) :]).max() < 0.01, "the last sound decays"
    assert len(sound) > TAIL_S * RATE


@pytest.mark.slow
@pytest.mark.parametrize("name", SESSIONS)
def test_the_higher_the_true_hover_the_sharper_the_sound(
    sensed: Callable[[str, float], Any], name: str
) -> None:
    """The same drum, hit in each frame that shows the other hand."""
    session = sensed(name, SECONDS)
    drumming = {line["contact"]["hand"] for line in session.truth if "contact" in line}
    true_mm = {
        line["time_us"]: [
            each["height_mm"] for each in line["fingers"] if each["hand"] not in drumming
        ]
        for line in session.truth
        if "fingers" in line
    }
    # 100 mm, so that no height is clipped: the sensed one may be some mm too high.
    bank, player = make_bank(KIT), Player(settings=Settings(high_mm=100.0))
    pairs = []
    for frame in halo_client.frames(FileSource(session.stream, paced=False)):
        shapes = [each for each in player.process(frame) if isinstance(each, Shape)]
        if shapes and true_mm.get(frame.time_us):
            mixer = Mixer(bank, Settings(resting=shapes[0].height))
            mixer.apply(Hit(0, TouchKey("", "", "", 1, 1), pad_at(KIT, 0.6, 0.3), 0.8, 0.6, 0.3))
            sound = np.concatenate([mixer.block() for _ in range(40)])
            pairs.append((min(true_mm[frame.time_us]), centroid_hz(sound)))
    heights, centroids = np.array(pairs).T
    steps = np.floor(heights / STEP_MM)
    means = [
        float(centroids[steps == step].mean())
        for step in np.unique(steps)
        if np.count_nonzero(steps == step) >= 5
    ]
    print(f"{heights.min():.0f} to {heights.max():.0f} mm: {np.round(means)} Hz")
    assert len(means) >= 4
    assert all(low < high for low, high in pairwise(means))


def centroid_hz(sound: NDArray[np.float32]) -> float:
    power = np.abs(np.fft.rfft(sound.mean(axis=1))) ** 2
    return float((power * np.fft.rfftfreq(len(sound), 1 / RATE)).sum() / power.sum())


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(5))
def test_with_a_fifth_of_the_datagrams_lost_still_one_sound_per_hit(
    sensed: Callable[[str, float], Any], seed: int
) -> None:
    session = sensed(SESSIONS[0], SECONDS)

    def hits(loss: float) -> list[tuple[int, Hit]]:
        lost, encoder, assembler, player = (
            random.Random(seed),
            FrameEncoder("sim", "s1", 0),
            Assembler(),
            Player(),
        )
        found = []
        for number, frame in enumerate(session.frames):
            for datagram in encoder.encode(frame).datagrams:
                # The first frame always arrives: a client that joins later gets no earlier hits.
                if number and lost.random() < loss:
                    continue
                for event in assembler.receive_data(datagram, frame.time_us / 1e6):
                    if isinstance(event, TouchFrame):
                        gestures = player.process(event)
                        found += [(event.frame, hit) for hit in gestures if isinstance(hit, Hit)]
        return found

    complete, lossy = hits(0.0), hits(0.2)
    late = {hit.key: arrived for arrived, hit in lossy}
    assert len(late) == len(lossy), "no hit sounds twice"
    assert [hit.key for _, hit in complete] == [hit.key for _, hit in lossy]
    delays = [late[hit.key] - arrived for arrived, hit in complete]
    print("frames late:", delays)
    assert all(0 <= delay <= 6 for delay in delays)
