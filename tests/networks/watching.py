"""What `halo monitor --json` has printed so far."""

from __future__ import annotations

import json
import time
from collections.abc import Callable

from tests.networks.lab import Program


def frames(program: Program) -> list[dict[str, object]]:
    """The frames that `halo monitor --json` has printed, without a line that is not whole."""
    whole = program.text.rpartition("\n")[0].splitlines()
    lines = [json.loads(line) for line in whole if line.startswith("{")]
    return [line for line in lines if line["kind"] == "frame"]


def waited(condition: Callable[[], object], within_s: float) -> float:
    """Wait for something; return how long it took, in seconds."""
    began_s = time.monotonic()
    while not condition():
        assert time.monotonic() < began_s + within_s, "it did not happen in time"
        time.sleep(0.02)
    return time.monotonic() - began_s


def arrive(program: Program, within_s: float = 20.0) -> float:
    """Wait for new frames; return how long it took, in seconds."""
    before = len(frames(program))
    return waited(lambda: len(frames(program)) > before + 1, within_s)
