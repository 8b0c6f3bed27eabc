"""The files of the page, read once at the start.

Rule: requests choose from this table by its keys; no path of a request is opened.
"""

from __future__ import annotations

import gzip
import hashlib
from pathlib import Path
from typing import NamedTuple

FOLDER = Path(__file__).parent / "static"
TYPES = {
    ".html": "text/html; charset=utf-8",
    ".css": "text/css; charset=utf-8",
    ".js": "text/javascript; charset=utf-8",
    ".svg": "image/svg+xml",
}


class StaticFile(NamedTuple):
    """One file."""

    type: str
    content: bytes
    zipped: bytes
    etag: str


def static_files() -> dict[str, StaticFile]:
    """Read the files: path in the URL -> file; `/` is the page itself."""
    files = {
        f"/{path.relative_to(FOLDER).as_posix()}": _read(path)
        for path in sorted(FOLDER.rglob("*"))
        if path.suffix in TYPES
    }
    return {"/": files["/index.html"], **files}


def _read(path: Path) -> StaticFile:
    content = path.read_bytes()
    etag = f'"{hashlib.sha256(content).hexdigest()[:16]}"'
    return StaticFile(TYPES[path.suffix], content, gzip.compress(content, mtime=0), etag)
