"""Starts the real `halo` command, and ends what it started."""

from __future__ import annotations

import signal
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

HALO = Path(sys.executable).with_name("halo")
Spawn = Callable[..., "subprocess.Popen[str]"]


@pytest.fixture
def spawn() -> Iterator[Spawn]:
    """Start a program with its output piped; whatever still runs at the end is ended."""
    started: list[subprocess.Popen[str]] = []

    def start(*command: str | Path) -> subprocess.Popen[str]:
        process = subprocess.Popen(
            [str(part) for part in command],
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )
        started.append(process)
        return process

    yield start
    for process in started:
        if process.poll() is None:
            process.send_signal(signal.SIGTERM)
            try:
                process.wait(10.0)
            except subprocess.TimeoutExpired:
                process.kill()
        process.communicate()


@pytest.fixture
def serve(spawn: Spawn, free_port: Callable[[], int]) -> Callable[..., subprocess.Popen[str]]:
    """Start `halo serve` on ports of its own."""

    def start(*options: str) -> subprocess.Popen[str]:
        return spawn(HALO, "serve", "--control-port", str(free_port()), *options)

    return start
