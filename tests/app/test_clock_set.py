"""The clock of a running service's host is set back by 30 s: a line in `health`, nothing else."""

from __future__ import annotations

import socket
import sys
import time
from collections.abc import Callable, Iterator
from itertools import pairwise
from pathlib import Path
from subprocess import Popen

import numpy as np
import pytest

import halo_protocol as wire
from halo_service.geometry.camera import Camera, Lens
from halo_service.outputs.recorder import Recorder
from halo_service.values import Frame

HALO = """
import os, sys, time

now_ns, now_s = time.time_ns, time.time
time.time_ns = lambda: now_ns() + (SET_S * 10**9 if os.path.exists(sys.argv[1]) else 0)
time.time = lambda: time.time_ns() / 1e9

from halo_service.app.cli import main

sys.exit(main(sys.argv[2:]))
"""
"""The `halo` command on a host with a clock that is set when a file appears.

faketime cannot do that: once it changes the time, its sleep fails with "Invalid argument".
"""
PERIOD_US = 33_333
SET_S = -30


@pytest.fixture
def recording(tmp_path: Path) -> Path:
    """A second of an empty table."""
    camera = Camera(
        "S", "NFOV_2X2BINNED", 30, Lens(320, 288, 252.0, 252.0, 160.0, 144.0), None, np.eye(4)
    )
    flat = np.full((288, 320), 700, np.uint16)
    path = tmp_path / "table.mkv"
    with Recorder(path, camera, fps=30, colour=False) as recorder:
        for n in range(30):
            recorder.write(Frame(n * PERIOD_US, flat, flat))
    return path


def messages(client: socket.socket, seconds: float) -> Iterator[wire.Message]:
    until = time.monotonic() + seconds
    while time.monotonic() < until:
        for _, message in wire.decode(client.recv(65_536)):
            yield message


@pytest.mark.slow
def test_only_health_reports_it(
    recording: Path,
    spawn: Callable[..., Popen[str]],
    free_port: Callable[[], int],
    tmp_path: Path,
) -> None:
    clock_is_set = tmp_path / "set"
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as client:
        client.bind(("127.0.0.1", 0))
        client.settimeout(30.0)
        options = ["--source", f"recording:{recording}", "--loop", "--no-zenoh", "--no-web"]
        options += ["--osc", f"127.0.0.1:{client.getsockname()[1]}"]
        program = HALO.replace("SET_S", str(SET_S))
        command = [sys.executable, "-c", program, clock_is_set, "serve"]
        service = spawn(*command, "--control-port", str(free_port()), *options)
        client.recv(65_536)
        received = list(messages(client, 1.2))
        clock_is_set.touch()
        received += messages(client, 2.0)
        service.terminate()
        _, said = service.communicate(timeout=20.0)
    frames = [each for each in received if isinstance(each, wire.Frame)]
    healths = [each for each in received if isinstance(each, wire.Health)]
    assert {frame.session for frame in frames} == {frames[0].session}
    steps = [(b.frame - a.frame) % 2**24 for a, b in pairwise(frames)]
    assert steps == [1] * len(steps)
    # A busy machine may be late, but time neither goes back nor leaps.
    intervals_us = [b.time_us - a.time_us for a, b in pairwise(frames)]
    assert min(intervals_us) > 0
    assert max(intervals_us) < 1_500_000
    assert frames[-1].time_us - frames[0].time_us == pytest.approx(3.2e6, abs=1.5e6)
    assert abs(frames[-1].time_s - time.time()) < 10.0, "it follows slowly, not at once"
    assert (healths[0].clock_jumps, healths[-1].clock_jumps) == (0, 1)
    assert healths[-1].clock_error_ms == pytest.approx(SET_S * 1000, abs=100.0)
    assert {health.bad_frames for health in healths} == {0}
    assert said.count("the host's clock was set by -30.0 s") == 1
