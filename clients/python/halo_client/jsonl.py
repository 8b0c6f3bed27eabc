"""A recorded stream: a file with one line of JSON per frame.

Rule: each line is encoded to datagrams again, so that a recording goes through the same
assembler as a live stream. It reads the lines of `halo replay --jsonl` and those of
`halo-monitor --json`, which also contain scenes and homographies.
"""

from __future__ import annotations

import codecs
import json
import time
from collections import deque
from pathlib import Path
from typing import Any

from halo_client.errors import ClientError, EndOfStream
from halo_client.source import FileSource
from halo_protocol import (
    ZENOH_KINDS,
    Down,
    Frame,
    Pointer,
    ProtocolError,
    Up,
    encode,
    encode_frame,
    from_json,
    session_ms,
)

_REPORTS = frozenset(ZENOH_KINDS) - {"frame"}


_MARKS = {
    codecs.BOM_UTF8: "utf-8-sig",
    codecs.BOM_UTF16_LE: "utf-16",
    codecs.BOM_UTF16_BE: "utf-16",
}
"""What PowerShell's `>` and Windows editors write in front of a text, and what it means."""


def _encoding(path: Path) -> str:
    with path.open("rb") as file:
        start = file.read(3)
    return next((name for mark, name in _MARKS.items() if start.startswith(mark)), "utf-8")


class JsonlInput:
    """An open file, at its own speed or as fast as it is read. `ClientError` names a bad line."""

    def __init__(self, source: FileSource) -> None:
        self.url = str(source.path)
        self._paced = source.paced
        self._line = 0
        self._started: tuple[float, int] | None = None
        self._ready: deque[bytes] = deque()
        self._first_us: int | None = None
        self._due_s = 0.0
        try:
            self._file = source.path.open(encoding=_encoding(source.path))
        except OSError as error:
            raise ClientError(f"cannot read {source.path} ({error.strerror})") from error

    def receive(self, timeout_s: float) -> tuple[bytes, str] | None:
        """The next datagram when it is due, else None; `EndOfStream` at the end."""
        while not self._ready:
            self._read_line()
        wait_s = self._due_s - time.monotonic() if self._paced else 0.0
        if wait_s > timeout_s:
            time.sleep(timeout_s)
            return None
        if wait_s > 0:
            time.sleep(wait_s)
        return self._ready.popleft(), self.url

    def close(self) -> None:
        """Close the file. May be called twice."""
        self._file.close()

    def _read_line(self) -> None:
        try:
            text = self._file.readline()
        except UnicodeDecodeError as error:
            raise ClientError(
                f"{self.url} is not a recorded stream: it is not UTF-8 text"
            ) from error
        if not text:
            if self._started is None:
                raise ClientError(
                    f"{self.url} has no frames; record it again, with "
                    "`halo monitor --json` while `halo serve` runs"
                )
            raise EndOfStream
        self._line += 1
        if not text.strip():
            return
        try:
            line = json.loads(text)
            if not isinstance(line, dict):
                raise TypeError("an object is expected")
            if "time_us" in line:
                self._due_s = self._due(line["time_us"])
            self._ready.extend(datagrams(line, self._first_us))
        except (ValueError, KeyError, TypeError, AttributeError, ProtocolError) as error:
            reason = f"no {error}" if isinstance(error, KeyError) else error
            raise ClientError(
                f"{self.url}, line {self._line}, is not a frame ({reason}); "
                "`halo replay ... --jsonl FILE` writes such files"
            ) from error

    def _due(self, time_us: int) -> float:
        if self._started is None:
            self._started = time.monotonic(), time_us
            self._first_us = time_us
        started_s, first_us = self._started
        return started_s + (time_us - first_us) / 1e6


def datagrams(line: dict[str, Any], first_us: int | None = None) -> list[bytes]:
    """The datagrams of a line. `ProtocolError` or `KeyError` if a field is missing.

    `first_us`: time of the first frame, for lines without `session_ms`.
    """
    kind = line.get("kind", "frame")
    if kind in _REPORTS:
        return [encode(line["surface"], from_json(kind, line))]
    if kind != "frame":
        return []  # Such as `lost`: an observation of the receiver, never sent.
    pointers = [from_json("pointer", each) for each in line["pointers"]]
    events = [from_json(each["kind"], each) for each in line["events"]]
    time_us: int = line["time_us"]
    time = divmod(time_us, 1_000_000)
    since_ms = session_ms(time_us, time_us if first_us is None else first_us)
    since_ms = line.get("session_ms", since_ms)
    header = Frame(line["node"], line["session"], line["frame"], *time, len(pointers), since_ms)
    return encode_frame(
        line["surface"],
        header,
        [each for each in pointers if isinstance(each, Pointer)],
        [each for each in events if isinstance(each, Down)],
        [each for each in events if isinstance(each, Up)],
    )
