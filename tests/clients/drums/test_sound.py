"""The sound of the drums: timing, timbre, no clicks, peaks below full scale."""

from __future__ import annotations

import time
import wave
from itertools import pairwise
from pathlib import Path
from typing import Any

import miniaudio
import numpy as np
import pytest
from numpy.typing import NDArray

from halo_client import TouchKey
from halo_drums.bank import SAMPLES, Bank, make_bank
from halo_drums.kit import KIT, Pad
from halo_drums.mixer import BLOCK, CEILING, VOICES, Mixer
from halo_drums.player import Hit, Press, Release, Shape
from halo_drums.render import TAIL_S, render, write_wav
from halo_drums.speakers import Speakers
from halo_drums.voices import RATE

PADS = {pad.name: pad for pad in KIT}
Sound = NDArray[np.float32]


@pytest.fixture(scope="module")
def bank() -> Bank:
    return make_bank(KIT)


def key(contacts: int) -> TouchKey:
    return TouchKey("desk", "table", "s1", 1, contacts)


def hit(pad: Pad, contacts: int = 1, level: float = 0.8) -> Hit:
    return Hit(0, key(contacts), pad, level, 0.5, 0.5)


def blocks(mixer: Mixer, count: int) -> Sound:
    return np.concatenate([mixer.block() for _ in range(count)])


def at_height(bank: Bank, height: float) -> Mixer:
    mixer = Mixer(bank)
    mixer.apply(Shape(0, height))
    blocks(mixer, 60)
    return mixer


def centroid_hz(sound: Sound) -> float:
    power = np.abs(np.fft.rfft(sound.mean(axis=1))) ** 2
    hz = np.fft.rfftfreq(len(sound), 1 / RATE)
    return float((power * hz).sum() / power.sum())


@pytest.mark.parametrize("name", PADS)
def test_samples_start_and_end_at_zero_and_differ(bank: Bank, name: str) -> None:
    samples = bank[name]
    assert len(samples) == SAMPLES
    assert all(np.abs(sample[[0, -1]]).max() < 1e-6 for sample in samples)
    assert all(np.isfinite(sample).all() and np.abs(sample).max() <= 1.2 for sample in samples)
    assert np.abs(samples[0] - samples[1]).max() > 0.01


@pytest.mark.parametrize("name", PADS)
def test_the_higher_the_other_hand_the_sharper_the_sound(bank: Bank, name: str) -> None:
    centroids = []
    for height in np.linspace(0.0, 1.0, 9):
        mixer = at_height(bank, float(height))
        mixer.apply(hit(PADS[name]))
        centroids.append(centroid_hz(blocks(mixer, 100)))
    print(name, [round(hz) for hz in centroids])
    assert all(low < high for low, high in pairwise(centroids))
    assert centroids[-1] > 2 * centroids[0]


def test_the_hand_shapes_a_sound_that_already_plays(bank: Bank) -> None:
    sounds = []
    for height in (0.0, 1.0):
        mixer = at_height(bank, 0.5)
        mixer.apply(hit(PADS["open hat"]))
        blocks(mixer, 10)
        mixer.apply(Shape(0, height))
        sounds.append(blocks(mixer, 60))
    assert centroid_hz(sounds[1]) > 1.5 * centroid_hz(sounds[0])


@pytest.mark.parametrize("name", PADS)
def test_a_harder_strike_is_louder_and_brighter(bank: Bank, name: str) -> None:
    sounds = []
    for level in (0.25, 1.0):
        mixer = at_height(bank, 0.5)
        mixer.apply(hit(PADS[name], level=level))
        sounds.append(blocks(mixer, 60))
    assert np.abs(sounds[1]).max() > 2 * np.abs(sounds[0]).max()
    assert centroid_hz(sounds[1]) > centroid_hz(sounds[0])


def test_a_hit_starts_at_its_output_sample(bank: Bank) -> None:
    for offset in (0, 1, 100, BLOCK - 1):
        mixer = Mixer(bank)
        mixer.apply(hit(PADS["snare"]), offset)
        sound = blocks(mixer, 3)
        assert int(np.flatnonzero(np.abs(sound).max(axis=1) > 1e-4)[0]) in range(offset, offset + 8)


def test_pressing_bends_a_tom_and_mutes_a_hat(bank: Bank) -> None:
    def sound(name: str, amount: float) -> Sound:
        mixer = at_height(bank, 0.0)
        mixer.apply(hit(PADS[name]))
        blocks(mixer, 10)
        mixer.apply(Press(0, key(1), amount))
        return blocks(mixer, 40)

    assert centroid_hz(sound("low tom", 1.0)) > 1.2 * centroid_hz(sound("low tom", 0.0))
    free, muted = sound("open hat", 0.0), sound("open hat", 1.0)
    assert np.abs(muted[20 * BLOCK :]).max() < 0.1 * np.abs(free[20 * BLOCK :]).max()


def test_closing_the_hat_chokes_the_open_one(bank: Bank) -> None:
    mixer = Mixer(bank)
    mixer.apply(hit(PADS["open hat"], 1))
    blocks(mixer, 5)
    mixer.apply(hit(PADS["closed hat"], 2))
    blocks(mixer, 5)
    assert mixer.sounding == 1


def test_peaks_stay_below_full_scale(bank: Bank) -> None:
    mixer = Mixer(bank)
    rng = np.random.default_rng(5)
    peak, most = 0.0, 0
    for number in range(400):
        for _ in range(3):
            mixer.apply(hit(KIT[rng.integers(len(KIT))], number, 1.0), int(rng.integers(BLOCK)))
        peak = max(peak, float(np.abs(mixer.block()).max()))
        most = max(most, mixer.sounding)
    print("peak", peak, "voices", most)
    assert peak < CEILING < 1.0
    assert most <= VOICES + 12, "faded voices end within some blocks"


def test_changes_by_hand_press_and_choke_do_not_click(bank: Bank) -> None:
    """A click is a jump: changes to a deep sound keep its slope below a bound."""
    deep = {
        pad.name: [sample * np.float32([1, 1, 0, 0]) for sample in bank[pad.name]] for pad in KIT
    }

    def steepest(*changes: Any) -> float:
        mixer = at_height(deep, 0.3)
        mixer.apply(hit(PADS["low tom"]))
        sound = [mixer.block() for _ in range(20)]
        for change in changes:
            mixer.apply(change)
            sound += [mixer.block() for _ in range(3)]
        return float(np.abs(np.diff(np.concatenate(sound)[15 * BLOCK :], axis=0)).max())

    calm = steepest(*[Release(0, key(9))] * 6)
    wild = steepest(
        Shape(0, 0.0), Press(0, key(1), 1.0), Shape(0, 0.6), Press(0, key(1), 0.2),
        Release(0, key(1)), Shape(0, 0.2),
    )  # fmt: skip
    assert wild < 2.0 * calm


def test_a_rendered_hit_is_exact_to_the_sample(wire: Any, tmp_path: Path) -> None:
    frames = [wire.frame(0), wire.frame(30, downs=(wire.down(ago_ms=10.0),)), wire.frame(60)]
    sound = render(frames)
    assert len(sound) == round(
        (frames[-1].time_us - frames[0].time_us) * RATE / 1e6 + TAIL_S * RATE
    )
    first = int(np.flatnonzero(np.abs(sound).max(axis=1) > 1e-4)[0])
    assert abs(first - round((30 * 33_333 - 10_000) * RATE / 1e6)) < 10
    write_wav(tmp_path / "it.wav", sound)
    with wave.open(str(tmp_path / "it.wav")) as file:
        assert (file.getnchannels(), file.getframerate(), file.getnframes()) == (
            2,
            RATE,
            len(sound),
        )


def test_an_empty_stream_is_an_empty_sound() -> None:
    assert render([]).shape == (0, 2)


def test_live_sound_has_no_gaps(bank: Bank) -> None:
    """1.5 s here; `benchmarks/drums.py` runs for a minute."""
    with Speakers(Mixer(bank), [miniaudio.Backend.NULL]) as speakers:
        for number in range(15):
            speakers.send(hit(KIT[number % len(KIT)], number))
            speakers.send(Shape(0, number / 15))
            time.sleep(0.1)
        print("gaps", speakers.gaps, "slowest", speakers.slowest)
        assert speakers.made_s > 1.0
        assert speakers.gaps <= 1, "a busy machine may miss one period"
