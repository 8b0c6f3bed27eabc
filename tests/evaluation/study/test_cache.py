"""Takes are kept whole or not at all, and a run that was killed goes on where it was."""

from __future__ import annotations

import signal
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import pytest
from filelock import Timeout

from halo_service.evaluation.study import recording as kept_module
from halo_service.evaluation.study.cache import Studio
from halo_service.evaluation.study.plan import CALIBRATION, Task
from halo_service.evaluation.study.recording import Kept, load, save
from tests.evaluation.study.empty_table import LONG, PERSON, SHORT, studio_in


@pytest.fixture(scope="module")
def studio(tmp_path_factory: pytest.TempPathFactory) -> Studio:
    return studio_in(tmp_path_factory.mktemp("takes"))


def test_a_take_that_is_kept_is_not_drawn_again_and_another_one_is(studio: Studio) -> None:
    studio.provide(PERSON, SHORT)
    first = studio.path(PERSON, SHORT).stat().st_mtime_ns
    assert len(load(studio.path(PERSON, SHORT)).captures) == 15
    studio.provide(PERSON, SHORT)
    assert studio.path(PERSON, SHORT).stat().st_mtime_ns == first
    replace(studio, tracker="another").provide(PERSON, SHORT)
    assert studio.path(PERSON, SHORT).stat().st_mtime_ns > first


@pytest.mark.parametrize("harm", ["cut", "empty", "text"])
def test_a_damaged_take_is_made_anew(studio: Studio, harm: str) -> None:
    studio.provide(PERSON, SHORT)
    path = studio.path(PERSON, SHORT)
    whole = path.read_bytes()
    path.write_bytes({"cut": whole[: len(whole) // 2], "empty": b"", "text": b"no take"}[harm])
    assert not studio.has(PERSON, SHORT)
    studio.provide(PERSON, SHORT)
    assert path.read_bytes() == whole


def test_a_take_ends_half_a_second_after_its_last_touch(studio: Studio) -> None:
    task = Task("two", "demo", 12.0, ends=False, touches=2)
    studio.provide(PERSON, task)
    kept = load(studio.path(PERSON, task))
    contacts = [line["contact"] for line in kept.truth if "contact" in line]
    assert len(contacts) == 2
    after_s = (kept.captures[-1].time_us - contacts[-1]["to_us"]) / 1e6
    assert 0.4 <= after_s <= 0.6


def test_a_write_that_fails_leaves_nothing(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    def full(file: object, **arrays: object) -> None:
        file.write(b"half of it")  # type: ignore[attr-defined]
        raise OSError("No space left on device")

    monkeypatch.setattr(kept_module.np, "savez", full)
    with pytest.raises(OSError, match="No space"):
        save(tmp_path / "take.npz", Kept((), (), ()), "so")
    assert list(tmp_path.iterdir()) == []


KILLED = """
import sys
from pathlib import Path
sys.path.insert(0, {root!r})
from contextlib import contextmanager
from halo_service.evaluation.study.cache import Studio
from halo_service.values import Tracked
from tests.evaluation.study.empty_table import LONG, PERSON

@contextmanager
def telling(camera, profile, hands):
    def look(frame):
        print("frame", flush=True)
        return Tracked(frame.time_us, ())
    yield look

Studio(Path({folder!r}), telling, "nobody").provide(PERSON, LONG)
"""


def test_a_run_that_is_killed_in_mid_take_leaves_nothing_and_goes_on(studio: Studio) -> None:
    folder = studio.folder
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
    assert not studio.has(PERSON, LONG)
    assert studio.has(PERSON, CALIBRATION)


def test_what_a_killed_write_left_is_swept_up_by_the_next_run(studio: Studio) -> None:
    left = studio.of(PERSON) / ".short.npz.123.part"
    left.write_bytes(b"half of it")
    with studio.to_itself():
        assert not left.exists()


def test_two_runs_do_not_fill_the_same_folder(
    studio: Studio, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("halo_service.files.LOCK_WAIT_S", 0.05)
    with studio.to_itself():
        with pytest.raises(Timeout), studio.to_itself():
            pass
        with replace(studio, draws=False).to_itself():
            pass  # who only reads, reads on
