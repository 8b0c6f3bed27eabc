"""The sounds of keys: heard at once, short, and different for letters, delete and done."""

import numpy as np
import pytest

from halo_drums.mixer import BLOCK, Mixer
from halo_drums.voices import RATE
from halo_type.layout import DELETE, DONE
from halo_type.sounds import key_sounds, sound_of
from halo_type.typist import Struck


@pytest.fixture(scope="module")
def bank():
    return key_sounds()


def heard(bank, *characters):
    """0.6 s after keys that are struck at once."""
    mixer = Mixer(bank)
    for number, character in enumerate(characters):
        mixer.apply(sound_of(Struck(number, character, 0.0, 0.0)))
    return np.concatenate([mixer.block() for _ in range(round(0.6 * RATE / BLOCK))])


@pytest.mark.parametrize("character", ["a", " ", DELETE, DONE])
def test_a_key_is_heard_at_once_and_for_less_than_half_a_second(bank, character):
    loud = np.abs(heard(bank, character)).max(axis=1)
    assert 0.05 < loud.max() < 1.0
    assert np.flatnonzero(loud > 0.02)[0] < 0.005 * RATE
    assert loud[round(0.5 * RATE) :].max() < 0.01


def test_letters_sound_alike_and_other_keys_do_not(bank):
    a, b, delete, done = (heard(bank, each) for each in ("a", "b", DELETE, DONE))
    assert np.array_equal(a, b)
    assert not np.allclose(a, delete) and not np.allclose(delete, done)


def test_two_keys_at_once_stay_below_the_limit_and_no_key_is_silent(bank):
    assert np.abs(heard(bank, *"abcdefgh")).max() < 1.0
    assert sound_of(Struck(0, None, 0.0, 0.0)) is None
