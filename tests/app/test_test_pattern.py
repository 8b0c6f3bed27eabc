"""`halo test-pattern` sends what a client needs to show a finger, without a camera."""

from __future__ import annotations

import socket
import subprocess
import time
from collections.abc import Callable

import halo_protocol as wire
from tests.app.conftest import HALO


def test_a_client_sees_the_circle_the_surface_and_the_end(
    spawn: Callable[..., subprocess.Popen[str]],
) -> None:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as client:
        client.bind(("127.0.0.1", 0))
        client.settimeout(20.0)
        place = f"127.0.0.1:{client.getsockname()[1]}"
        sender = spawn(HALO, "test-pattern", place, "--seconds", "1")
        seen: list[wire.Message] = []
        until_s = time.monotonic() + 30.0
        while not _is_over(seen):
            assert time.monotonic() < until_s
            seen += [message for _, message in wire.decode(client.recv(65_536))]
        assert sender.wait(20.0) == 0
    pointers = [each for each in seen if isinstance(each, wire.Pointer)]
    assert len({(each.x_mm, each.y_mm) for each in pointers}) > 10
    assert any(isinstance(each, wire.Down) for each in seen)
    (scene, *_) = [each for each in seen if isinstance(each, wire.Scene)]
    assert (scene.width_mm, scene.height_mm) == (300.0, 200.0)
    assert any(isinstance(each, wire.Health) for each in seen)


def _is_over(seen: list[wire.Message]) -> bool:
    """Whether a frame without pointers came after those with one."""
    frames = [each for each in seen if isinstance(each, wire.Frame)]
    return len(frames) > 1 and frames[-1].count == 0
