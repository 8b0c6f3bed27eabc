"""A virtual room is measured once, and again when anything that it depends on changes."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from halo_service.app.virtual_user import cache
from halo_service.app.virtual_user.cache import MOST_ROOMS, cached_profile
from halo_service.profile import Profile
from halo_service.settings import Settings
from halo_service.virtual.room import Room, draw_room


@pytest.fixture
def measured(
    profile: Profile, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> list[tuple[Room, Settings]]:
    """The rooms that were measured so far, with `get` as the way to a profile."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    (tmp_path / "hand.task").write_bytes(b"one")
    monkeypatch.setattr(cache, "model_for", lambda tracking: tmp_path / "hand.task")
    return []


def get(measured: list[tuple[Room, Settings]], room: Room, profile: Profile) -> Profile:
    def measure(room: Room, settings: Settings) -> Profile:
        measured.append((room, settings))
        return profile

    return cached_profile(room, Settings(), measure)


def test_a_room_is_measured_once(
    measured: list[tuple[Room, Settings]], profile: Profile, tmp_path: Path
) -> None:
    first = get(measured, draw_room(3), profile)
    again = get(measured, draw_room(3), profile)
    assert len(measured) == 1
    assert again.touch == first.touch
    assert np.array_equal(again.background.mean_mm, first.background.mean_mm)
    get(measured, draw_room(4), profile)
    get(measured, draw_room(3, material="foam"), profile)
    get(measured, draw_room(3, camera_pitch_deg=2.0), profile)
    assert len(measured) == 4
    (tmp_path / "hand.task").write_bytes(b"another")
    get(measured, draw_room(3), profile)
    assert len(measured) == 5


def test_what_shows_a_file_is_measured_at_every_start(
    measured: list[tuple[Room, Settings]], profile: Profile
) -> None:
    room = replace(draw_room(3), projected="picture.png")
    for _ in range(2):
        get(measured, room, profile)
    assert len(measured) == 2


def test_a_damaged_file_is_measured_again(
    measured: list[tuple[Room, Settings]], profile: Profile, tmp_path: Path
) -> None:
    get(measured, draw_room(3), profile)
    (text,) = tmp_path.glob("cache/halo-service/virtual-profiles/*/profile.json")
    text.write_text("{")
    get(measured, draw_room(3), profile)
    get(measured, draw_room(3), profile)
    assert len(measured) == 2


def test_the_cache_is_bounded_and_one_that_cannot_be_written_is_no_error(
    measured: list[tuple[Room, Settings]],
    profile: Profile,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    for seed in range(MOST_ROOMS + 3):
        get(measured, draw_room(seed), profile)
    folder = tmp_path / "cache" / "halo-service" / "virtual-profiles"
    assert len(list(folder.iterdir())) == MOST_ROOMS
    (tmp_path / "file").write_text("")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "file"))
    assert get(measured, draw_room(3), profile) is profile
