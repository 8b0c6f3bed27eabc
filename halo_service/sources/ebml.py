"""Check a Matroska file before it is read: is it one, and is it complete?

Rule: nothing here depends on the recorded content. Matroska is written in EBML (RFC 8794): an
element is an identity, a size and a content, and the element Segment holds everything.
"""

from __future__ import annotations

from pathlib import Path
from typing import BinaryIO

from halo_service.errors import UserError

_EBML = b"\x1a\x45\xdf\xa3"
_START_BYTES = 256
"""Enough to recognise what is often saved under the name of a recording."""
_SEGMENT = b"\x18\x53\x80\x67"


def open_matroska(path: Path) -> BinaryIO:
    """Open `path`; raises UserError if there is no file or it is not Matroska."""
    try:
        file = path.open("rb")
    except FileNotFoundError as error:
        raise UserError(f"{path} does not exist; check the recording's path.") from error
    except IsADirectoryError as error:
        raise UserError(f"{path} is a folder; name the recording inside it.") from error
    except OSError as error:
        raise UserError(
            f"{path} cannot be opened ({error.strerror}); check its permissions."
        ) from error
    start = file.read(_START_BYTES)
    if start.startswith(_EBML):
        file.seek(0)
        return file
    file.close()
    raise UserError(f"{path} {_what_it_is(start)}")


def _what_it_is(start: bytes) -> str:
    """Say what a file is that begins like this and is not Matroska, and what to do."""
    text = start.lstrip(b"\xef\xbb\xbf \t\r\n").lower()
    if text.startswith(b"version https://git-lfs"):
        return "is a Git LFS pointer and not the recording itself: run 'git lfs pull' there."
    if text.startswith((b"<!doctype html", b"<html")):
        return "is a web page and not a recording: download the file itself again."
    if not start:
        return "is empty: copy or record it again."
    return "is not a Matroska file; name a recording made by an Azure Kinect (.mkv)."


def declared_size(file: BinaryIO) -> int | None:
    """Return the size in the file's own header; None if it was never closed or is cut off earlier.

    FFmpeg reads a truncated Matroska file to its last whole packet and then reports a normal
    end. The Segment (EBML, RFC 8794) is the element that holds everything, with its size.
    """
    position = 0
    while True:
        file.seek(position)
        head = file.read(12)
        if len(head) < 6:
            return None
        identity = head[:4]
        length = 9 - head[4].bit_length()
        if length > 8 or len(head) < 4 + length:
            return None
        size = int.from_bytes(head[4 : 4 + length]) & ((1 << 7 * length) - 1)
        end = position + 4 + length + size
        if identity == _SEGMENT:
            return None if size == (1 << 7 * length) - 1 else end
        if identity != _EBML:
            return None
        position = end
