"""Recordings are stored whole or not at all, and a killed run continues where it was."""

from __future__ import annotations

import signal
import subprocess
import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest
from filelock import Timeout

from halo_service.evaluation.study import recording as recording_module
from halo_service.evaluation.study.cache import RecordingCache
from halo_service.evaluation.study.plan import CALIBRATION, Task
from halo_service.evaluation.study.recording import StoredRecording, load, save
from tests.evaluation.study.empty_table import LONG, SHORT, USER

FRAMES = round(30 * SHORT.seconds)


def test_a_cached_recording_is_not_simulated_again(cache: RecordingCache) -> None:
    cache.ensure(USER, SHORT)
    first = cache.path(USER, SHORT).stat().st_mtime_ns
    assert len(load(cache.path(USER, SHORT)).frames) == FRAMES
    cache.ensure(USER, SHORT)
    assert cache.path(USER, SHORT).stat().st_mtime_ns == first


DAMAGE: dict[str, Callable[[bytes], bytes]] = {
    "cut": lambda whole: whole[: len(whole) // 2],
    "empty": lambda whole: b"",
    "text": lambda whole: b"no recording",
}


@pytest.mark.parametrize("damage", DAMAGE)
def test_a_damaged_recording_counts_as_absent(
    cache: RecordingCache, damage: str, tmp_path: Path
) -> None:
    cache.ensure(USER, SHORT)
    whole = cache.path(USER, SHORT).read_bytes()
    copy = replace(cache, folder=tmp_path)
    copy.path(USER, SHORT).parent.mkdir()
    copy.path(USER, SHORT).write_bytes(whole)
    assert copy.has(USER, SHORT)
    copy.path(USER, SHORT).write_bytes(DAMAGE[damage](whole))
    assert not copy.has(USER, SHORT)


def test_a_damaged_recording_is_simulated_again(cache: RecordingCache) -> None:
    cache.ensure(USER, SHORT)
    path = cache.path(USER, SHORT)
    whole = path.read_bytes()
    path.write_bytes(whole[: len(whole) // 2])
    cache.ensure(USER, SHORT)
    assert path.read_bytes() == whole


def test_another_tracker_makes_another_recording(cache: RecordingCache) -> None:
    cache.ensure(USER, SHORT)
    first = cache.path(USER, SHORT).stat().st_mtime_ns
    replace(cache, tracker="another").ensure(USER, SHORT)
    assert cache.path(USER, SHORT).stat().st_mtime_ns > first


def test_a_recording_ends_half_a_second_after_its_last_touch(cache: RecordingCache) -> None:
    task = Task("two", "demo", 12.0, ends=False, touches=2)
    cache.ensure(USER, task)
    recording = load(cache.path(USER, task))
    contacts = [line["contact"] for line in recording.truth if "contact" in line]
    assert len(contacts) == 2
    after_s = (recording.frames[-1].time_us - contacts[-1]["to_us"]) / 1e6
    assert 0.4 <= after_s <= 0.6


def test_a_write_that_fails_leaves_nothing(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    def full(file: object, **arrays: object) -> None:
        file.write(b"half of it")  # type: ignore[attr-defined]
        raise OSError("No space left on device")

    monkeypatch.setattr(recording_module.np, "savez", full)
    with pytest.raises(OSError, match="No space"):
        save(tmp_path / "recording.npz", StoredRecording((), (), ()), "key")
    assert list(tmp_path.iterdir()) == []


KILLED = """
import sys
from pathlib import Path
sys.path.insert(0, {root!r})
from contextlib import contextmanager
from halo_service.evaluation.study.cache import RecordingCache
from halo_service.values import Tracked
from tests.evaluation.study.empty_table import LONG, USER

@contextmanager
def announce(camera, profile, hands):
    def track(frame):
        print("frame", flush=True)
        return Tracked(frame.time_us, ())
    yield track

RecordingCache(Path({folder!r}), announce, "blind").ensure(USER, LONG)
"""


def test_a_run_that_is_killed_while_simulating_leaves_nothing(cache: RecordingCache) -> None:
    folder = cache.folder
    before = sorted(folder.rglob("*"))
    root = str(Path(__file__).parents[3])
    process = subprocess.Popen(
        [sys.executable, "-c", KILLED.format(root=root, folder=str(folder))],
        stdout=subprocess.PIPE,
        text=True,
    )
    assert process.stdout is not None
    with process.stdout:
        for _ in range(10):
            assert process.stdout.readline() == "frame\n"
        process.send_signal(signal.SIGKILL)
        process.wait()
    assert sorted(folder.rglob("*")) == before
    assert not cache.has(USER, LONG)
    assert cache.has(USER, CALIBRATION)


def test_what_a_killed_write_left_is_deleted_by_the_next_run(cache: RecordingCache) -> None:
    left = cache.path(USER, SHORT).parent / ".short.npz.123.part"
    left.write_bytes(b"half of it")
    with cache.exclusive():
        assert not left.exists()


def test_two_runs_do_not_write_to_the_same_folder(
    cache: RecordingCache, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("halo_service.files.LOCK_WAIT_S", 0.05)
    with cache.exclusive():
        with pytest.raises(Timeout), cache.exclusive():
            pass
        with replace(cache, simulates=False).exclusive():
            pass  # reading needs no lock
