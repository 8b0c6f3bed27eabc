"""A profile in one file, to carry elsewhere.

Rule: what comes in is distrusted. Only the names a profile has, only the sizes a profile can
have, and it must load; else one sentence, and nothing is left behind.
"""

from __future__ import annotations

import io
import json
import re
import struct
import tempfile
import zipfile
import zlib
from pathlib import Path
from typing import IO, Any

import numpy as np

from halo_service.errors import UserError
from halo_service.files import appearing
from halo_service.profile.model import Profile
from halo_service.profile.store import TEXT, load

NAMES = re.compile(r"profile\.json|(background|correction)-[0-9a-f]{12}\.npz")
MOST_FILES = 3
MOST_BYTES = 32 << 20
"""Of one file unpacked: four times the largest that a profile holds."""


def pack(folder: Path, out: Path) -> None:
    """Write a profile into one file. Raises `UserError`."""
    load(folder)  # whatever is sent must be readable there
    try:
        text = (folder / TEXT).read_bytes()
        files = {TEXT: text}
        for name in _named(text):
            files[name] = (folder / name).read_bytes()
        with appearing(out) as file, zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED) as archive:
            for name, content in files.items():
                archive.writestr(zipfile.ZipInfo(name), content)
    except OSError as error:
        raise UserError(
            f"'{out}' cannot be written ({error.strerror}); choose another place"
        ) from error


def unpack(path: Path) -> Profile:
    """Read a profile out of a file from anywhere. Raises `UserError` for anything else."""
    try:
        with (
            zipfile.ZipFile(path) as archive,
            tempfile.TemporaryDirectory(prefix="halo-profile-") as folder,
        ):
            for name, content in _checked(archive).items():
                (Path(folder) / name).write_bytes(content)
            return load(Path(folder))
    except (ValueError, OSError, RuntimeError) as error:
        raise _refused(path, error) from error
    except (zipfile.BadZipFile, zlib.error, struct.error, SyntaxError, EOFError) as error:
        raise UserError(
            f"'{path}' is not an exported profile; give a file that 'halo profile export' wrote"
        ) from error


def _named(text: bytes) -> list[str]:
    """Return the array files that a profile's text names."""
    data = json.loads(text)
    correction = data.get("correction")
    return [data["background"], *([correction["arrays"]] if correction else [])]


def _checked(archive: zipfile.ZipFile) -> dict[str, bytes]:
    """Return the files by name. Raises ValueError for what no profile holds."""
    members = archive.infolist()
    names = [member.filename for member in members]
    if len(names) > MOST_FILES or len(set(names)) < len(names):
        raise ValueError(f"it holds {len(names)} files; a profile has at most {MOST_FILES}")
    for name in names:
        if not NAMES.fullmatch(name):
            raise ValueError(f"it holds {name[:60]!r}, which is no part of a profile")
    if TEXT not in names:
        raise ValueError(f"it holds no {TEXT}")
    files = {}
    for member in members:
        with archive.open(member) as file:
            content = file.read(MOST_BYTES + 1)  # whatever the directory says of its size
        if len(content) > MOST_BYTES:
            raise ValueError(f"its {member.filename} is larger than any profile's")
        if member.filename != TEXT:
            _check_arrays(content, member.filename)
        files[member.filename] = content
    return files


def _check_arrays(content: bytes, name: str) -> None:
    """Check the arrays' headers before memory is allocated for them."""
    with zipfile.ZipFile(io.BytesIO(content)) as arrays:
        for member in arrays.infolist():
            with arrays.open(member) as file:
                shape, dtype = _header(file)
            size = int(np.prod(shape, dtype=object)) * dtype.itemsize
            if dtype.hasobject or size > MOST_BYTES:
                raise ValueError(f"its {name} holds an array that no profile has")


def _header(file: IO[bytes]) -> tuple[tuple[int, ...], np.dtype[Any]]:
    major = np.lib.format.read_magic(file)[0]  # type: ignore[no-untyped-call]
    if major == 1:
        shape, _, dtype = np.lib.format.read_array_header_1_0(file)  # type: ignore[no-untyped-call]
    else:
        shape, _, dtype = np.lib.format.read_array_header_2_0(file)  # type: ignore[no-untyped-call]
    return shape, dtype


def _refused(path: Path, why: object) -> UserError:
    return UserError(
        f"'{path}' cannot be imported ({why}); give a file that 'halo profile export' wrote"
    )
