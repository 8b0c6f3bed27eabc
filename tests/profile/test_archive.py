"""A profile travels in one file, and nothing else comes in by it."""

from __future__ import annotations

import io
import json
import zipfile
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from halo_service.app import profiles
from halo_service.errors import UserError
from halo_service.geometry.camera import Camera, Lens
from halo_service.geometry.surface import Surface
from halo_service.profile import Background, Profile
from halo_service.profile.archive import MOST_BYTES, pack, unpack
from halo_service.profile.store import load, save

Files = dict[str, bytes]


@pytest.fixture
def archive(tmp_path: Path) -> Path:
    lens = Lens(8, 6, 500.0, 501.0, 3.5, 2.5)
    camera = Camera("A1", "NFOV_UNBINNED", 30, lens, None, np.eye(4))
    flat = np.full((6, 8), 500, np.float32)
    background = Background(flat, flat, flat > 0)
    profile = Profile("desk", camera, Surface("table", 3.0, 2.0, np.eye(4)), background, None, 1)
    save(profile, tmp_path / "desk")
    pack(tmp_path / "desk", tmp_path / "desk.halo")
    return tmp_path / "desk.halo"


def rewritten(archive: Path, change: Callable[[Files], Files]) -> Path:
    with zipfile.ZipFile(archive) as old:
        files = {name: old.read(name) for name in old.namelist()}
    out = archive.with_name("changed.halo")
    with zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED) as new:
        for name, content in change(files).items():
            new.writestr(name, content)
    return out


def array(files: Files) -> str:
    return next(name for name in files if name.startswith("background"))


def boast(files: Files) -> Files:
    """An array with a header that claims more memory than a computer has."""
    header = io.BytesIO()
    np.lib.format.write_array_header_1_0(
        header, {"descr": "<f4", "fortran_order": False, "shape": (1 << 40,)}
    )
    arrays = io.BytesIO()
    with zipfile.ZipFile(arrays, "w") as inner:
        inner.writestr("mean_mm.npy", header.getvalue())
    return files | {array(files): arrays.getvalue()}


def pickled(files: Files) -> Files:
    arrays = io.BytesIO()
    np.savez(arrays, mean_mm=np.array([{"a": 1}], dtype=object))
    return files | {array(files): arrays.getvalue()}


def renamed(files: Files) -> Files:
    data = json.loads(files["profile.json"]) | {"name": "../../elsewhere"}
    return files | {"profile.json": json.dumps(data).encode()}


def test_what_is_exported_is_imported(archive: Path, tmp_path: Path) -> None:
    folder = profiles.import_profile(archive, str(tmp_path / "there"))
    np.testing.assert_array_equal(
        load(folder).background.mean_mm, load(tmp_path / "desk").background.mean_mm
    )
    assert load(folder).name == "there"


@pytest.mark.parametrize(
    ("change", "says"),
    [
        (lambda f: f | {"../evil.txt": b"x"}, "'../evil.txt', which is no part"),
        (lambda f: f | {"/etc/evil": b"x"}, "no part of a profile"),
        (lambda f: f | {"a/profile.json": b"x"}, "no part of a profile"),
        (lambda f: f | {f"{n}.py": b"" for n in range(9)}, "holds 11 files"),
        (lambda f: f | {"profile.json": b" " * (MOST_BYTES + 2)}, "larger than any"),
        (lambda f: f | {array(f): b"\0" * (MOST_BYTES + 2)}, "larger than any"),
        (boast, "an array that no profile has"),
        (pickled, "an array that no profile has"),
        (lambda f: {array(f): f[array(f)]}, "no profile.json"),
        (lambda f: {"profile.json": f["profile.json"]}, "cannot be read"),
        (lambda f: f | {"profile.json": b"[]"}, "cannot be read"),
        (renamed, "is not a valid name"),
    ],
)
def test_foreign_files_are_refused_in_one_sentence(
    archive: Path, change: Callable[[Files], Files], says: str
) -> None:
    with pytest.raises(UserError, match=says):
        profiles.import_profile(rewritten(archive, change), None)


def test_what_is_no_archive_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "x.halo"
    path.write_bytes(b"PK no")
    with pytest.raises(UserError, match="is not an exported profile; give a file that 'halo prof"):
        unpack(path)
    with pytest.raises(UserError, match="cannot be imported"):
        unpack(tmp_path / "none.halo")


def test_a_flipped_byte_is_never_a_traceback(archive: Path) -> None:
    whole = archive.read_bytes()
    refused = 0
    for place in range(0, len(whole), 5):
        archive.write_bytes(whole[:place] + bytes([whole[place] ^ 0xFF]) + whole[place + 1 :])
        try:
            unpack(archive)
        except UserError:
            refused += 1
    assert refused > 0


def test_no_profile_is_written_over(archive: Path, tmp_path: Path) -> None:
    with pytest.raises(UserError, match="already"):
        profiles.import_profile(archive, str(tmp_path / "desk"))
    with pytest.raises(UserError, match="already"):
        profiles.copy(str(tmp_path / "desk"), str(tmp_path / "desk"))
