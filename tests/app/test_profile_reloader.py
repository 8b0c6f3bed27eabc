"""A running service loads a changed profile, and records its background again on request."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from halo_service.app.service.profile_reloader import ProfileReloader
from halo_service.errors import UserError
from halo_service.geometry.camera import Camera, Lens
from halo_service.geometry.surface import from_view
from halo_service.profile import Background, Profile
from halo_service.profile.store import amend, load, save
from halo_service.sensing import SensingSettings, State, start
from halo_service.values import Frame

SHAPE = (144, 160)
PATIENCE_S = 10.0


@pytest.fixture
def profile() -> Profile:
    lens = Lens(SHAPE[1], SHAPE[0], 125.0, 125.0, 79.5, 71.5)
    camera = Camera("A1", "NFOV_UNBINNED", 30, lens, None, np.eye(4))
    flat = np.full(SHAPE, 500.0, np.float32)
    background = Background(flat, np.ones(SHAPE, np.float32), flat > 0)
    surface = from_view(np.array([0.0, 0.0, 1.0]), 500.0)
    return Profile("desk", camera, surface, background, None, 1)


@pytest.fixture
def saved(profile: Profile, tmp_path: Path) -> Iterator[tuple[ProfileReloader, Path]]:
    folder = tmp_path / "desk"
    save(profile, folder)
    reloader = ProfileReloader(folder, profile.camera, profile)
    yield reloader, folder
    reloader.close()


def refreshed(reloader: ProfileReloader, state: State, wanted: Callable[[Profile], bool]) -> State:
    until = time.monotonic() + PATIENCE_S
    while time.monotonic() < until:
        state = reloader.refresh(state)
        if state.profile is not None and wanted(state.profile):
            return state
        time.sleep(0.02)
    pytest.fail("the profile was not taken up")


def frames(depth_mm: int) -> list[Frame]:
    rng = np.random.default_rng(1)
    noise = [np.rint(rng.normal(depth_mm, 1.0, SHAPE)).astype(np.uint16) for _ in range(60)]
    return [Frame(n * 33_333, depth, depth) for n, depth in enumerate(noise)]


def test_a_profile_changed_on_disk_is_taken_up(
    saved: tuple[ProfileReloader, Path], profile: Profile
) -> None:
    reloader, folder = saved
    amend(folder, lambda known: replace(known or profile, halo_threshold_mm=5.5))
    state = refreshed(reloader, start(profile, SensingSettings()), lambda p: p.revision == 2)
    assert state.profile is not None
    assert state.profile.halo_threshold_mm == 5.5


@pytest.mark.parametrize("name", ["profile.json", "background-*.npz"])
def test_a_spoilt_profile_leaves_the_one_that_was_there(
    saved: tuple[ProfileReloader, Path],
    profile: Profile,
    caplog: pytest.LogCaptureFixture,
    name: str,
) -> None:
    reloader, folder = saved
    (path,) = folder.glob(name)
    path.write_bytes(b"")
    (folder / "profile.json").touch()
    until = time.monotonic() + PATIENCE_S
    while "cannot be read" not in caplog.text and time.monotonic() < until:
        time.sleep(0.02)
    assert "the service goes on with the profile it has" in caplog.text
    state = start(profile, SensingSettings())
    assert reloader.refresh(state).profile is profile


def test_the_background_is_recorded_again_saved_and_announced_by_a_new_revision(
    saved: tuple[ProfileReloader, Path], profile: Profile
) -> None:
    reloader, folder = saved
    reloader.retake_background()
    for frame in frames(502):
        reloader.watch(frame)
    state = refreshed(reloader, start(profile, SensingSettings()), lambda p: p.revision == 2)
    assert state.profile is not None
    assert float(state.profile.background.mean_mm.mean()) == pytest.approx(502.0, abs=0.1)
    assert load(folder).revision == 2
    assert "background" in load(folder).steps


def test_a_background_in_which_something_moved_is_not_saved(
    saved: tuple[ProfileReloader, Path], profile: Profile, caplog: pytest.LogCaptureFixture
) -> None:
    reloader, folder = saved
    reloader.retake_background()
    for n, frame in enumerate(frames(500)):
        frame.depth[40:80, 40 + n : 80 + n] = 430
        reloader.watch(frame)
    until = time.monotonic() + PATIENCE_S
    while "something moved" not in caplog.text and time.monotonic() < until:
        time.sleep(0.02)
    assert "something moved" in caplog.text
    assert load(folder).revision == 1


def test_a_background_that_cannot_be_saved_is_counted_and_the_old_one_stays(
    saved: tuple[ProfileReloader, Path],
    profile: Profile,
    caplog: pytest.LogCaptureFixture,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def full(folder: Path, change: object) -> Profile:
        raise UserError(f"{folder} cannot be written (No space left on device)")

    reloader, folder = saved
    monkeypatch.setattr("halo_service.app.service.profile_reloader.amend", full)
    reloader.retake_background()
    for frame in frames(502):
        reloader.watch(frame)
    until = time.monotonic() + PATIENCE_S
    while reloader.write_errors == 0 and time.monotonic() < until:
        time.sleep(0.02)
    assert reloader.write_errors == 1
    assert load(folder).revision == 1
    assert reloader.refresh(start(profile, SensingSettings())).profile is profile


def test_without_a_profile_there_is_no_background_to_retake(profile: Profile) -> None:
    reloader = ProfileReloader(None, profile.camera, None)
    try:
        with pytest.raises(UserError, match="no profile yet"):
            reloader.retake_background()
    finally:
        reloader.close()
