"""The recorded streams that tests of clients share."""

from __future__ import annotations

import json
from functools import cache
from pathlib import Path
from typing import Any

import halo_client
from halo_client import FileSource
from halo_protocol import TouchFrame

FOLDER = Path(__file__).parent / "recorded"


@cache
def recorded(name: str) -> tuple[TouchFrame, ...]:
    """The frames of `drumming` or `painting`; see recorded/record.py."""
    return tuple(halo_client.frames(FileSource(FOLDER / f"{name}.jsonl", paced=False)))


@cache
def truth(name: str) -> dict[str, Any]:
    """What the virtual hand did."""
    read: dict[str, Any] = json.loads((FOLDER / f"{name}.truth.json").read_text())
    return read
