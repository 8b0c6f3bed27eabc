"""Files appear whole, and what was there before is never taken away."""

from __future__ import annotations

import os
import subprocess
import sys
import threading
from pathlib import Path

import numpy as np
import pytest

from halo_service.app.files import written
from halo_service.errors import UserError
from halo_service.files import appearing
from halo_service.virtual import gallery

posix = pytest.mark.skipif(sys.platform == "win32", reason="no FIFOs and devices on Windows")


def write(path: Path) -> None:
    with written(str(path)) as file:
        file.write("new\n")


def left_in(folder: Path) -> list[str]:
    return sorted(path.name for path in folder.iterdir())


def test_a_file_appears_when_it_is_complete(tmp_path: Path) -> None:
    with written(str(tmp_path / "out")) as file:
        file.write("new\n")
        assert not (tmp_path / "out").exists()
    assert (tmp_path / "out").read_text() == "new\n"
    assert left_in(tmp_path) == ["out"]


def test_what_fails_leaves_the_old_file_as_it_was(tmp_path: Path) -> None:
    (tmp_path / "out").write_text("old")
    with pytest.raises(RuntimeError, match="broke"), written(str(tmp_path / "out")) as file:
        file.write("new")
        raise RuntimeError("it broke")
    assert (tmp_path / "out").read_text() == "old"
    assert left_in(tmp_path) == ["out"]


@posix
@pytest.mark.parametrize("there", [True, False], ids=["a file", "nothing yet"])
def test_a_link_is_followed_and_stays_a_link(tmp_path: Path, there: bool) -> None:
    (tmp_path / "far").mkdir()
    if there:
        (tmp_path / "far" / "out").write_text("old")
    (tmp_path / "link").symlink_to(tmp_path / "far" / "out")
    write(tmp_path / "link")
    assert (tmp_path / "link").is_symlink()
    assert (tmp_path / "far" / "out").read_text() == "new\n"
    assert left_in(tmp_path / "far") == ["out"]


@posix
def test_a_fifo_is_written_to_and_stays_a_fifo(tmp_path: Path) -> None:
    fifo = tmp_path / "fifo"
    os.mkfifo(fifo)
    got: list[str] = []
    reader = threading.Thread(target=lambda: got.append(fifo.read_text()), daemon=True)
    reader.start()
    write(fifo)
    reader.join(10.0)
    assert got == ["new\n"]
    assert fifo.is_fifo()


@posix
def test_a_full_device_is_reported_and_stays(tmp_path: Path) -> None:
    if not Path("/dev/full").exists():
        pytest.skip("no /dev/full here")
    with pytest.raises(UserError, match="'/dev/full' cannot be written"):
        write(Path("/dev/full"))
    assert Path("/dev/full").is_char_device()


@pytest.mark.parametrize(
    ("out", "says"), [("", "has no name"), ("no/such/folder", "cannot be written"), (".", "cannot")]
)
def test_a_place_that_is_none_is_one_sentence(out: str, says: str) -> None:
    with pytest.raises(UserError, match=says):
        write(Path(out)) if out else written("").__enter__()


def test_a_gallery_that_cannot_be_written_deletes_nothing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    # Drawn small: the test checks where it goes.
    monkeypatch.setattr(gallery, "gallery", lambda seed, sensor: np.zeros((8, 8, 3), np.uint8))
    old = tmp_path / "old.png"
    old.write_text("the user's")
    (tmp_path / "link.png").symlink_to(old)
    gallery.save(tmp_path / "link.png")
    assert (tmp_path / "link.png").is_symlink()
    assert old.read_bytes().startswith(b"\x89PNG")
    with pytest.raises(UserError, match="cannot be written"):
        gallery.save(tmp_path / "none" / "new.png")
    if Path("/dev/full").exists():
        (tmp_path / "full.png").symlink_to("/dev/full")
        with pytest.raises(UserError, match="cannot be written"):
            gallery.save(tmp_path / "full.png")
        assert (tmp_path / "full.png").is_symlink()


def test_bytes_are_not_put_where_writing_them_broke(tmp_path: Path) -> None:
    with pytest.raises(KeyboardInterrupt), appearing(tmp_path / "out") as file:
        file.write(b"half")
        raise KeyboardInterrupt
    assert left_in(tmp_path) == []


@posix
def test_who_reads_our_lines_may_stop_at_any_time(company_data: Path) -> None:
    recording = company_data / "azure_kinect_desk.mkv"
    halo = [str(Path(sys.executable).with_name("halo")), "replay", str(recording), "--jsonl", "-"]
    reading, writing = os.pipe()
    os.close(reading)
    done = subprocess.run(halo, stdout=writing, stderr=subprocess.PIPE, text=True, timeout=60)
    os.close(writing)
    assert done.returncode == 0
    assert "Error" not in done.stderr
