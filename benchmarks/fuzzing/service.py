"""The real service for a benchmark: `halo serve` on ports of its own, with its memory and its log.

Its source is a small looped recording without a profile: frames come at 30 a second and cost
nothing, so all that is measured is how it receives and sends.
"""

from __future__ import annotations

import os
import socket
import subprocess
import sys
import time
from pathlib import Path
from types import TracebackType
from typing import Self

import numpy as np

from halo_service.geometry.camera import Camera, Lens
from halo_service.outputs.recorder import Recorder
from halo_service.values import Frame

START_S = 120.0
PERIOD_US = 33_333


def free_port(kind: socket.SocketKind) -> int:
    """Return a free port of the loopback."""
    with socket.socket(socket.AF_INET, kind) as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


def write_recording(path: Path) -> None:
    """Write two seconds of an empty table."""
    lens = Lens(320, 288, 252.0, 252.0, 160.0, 144.0)
    camera = Camera("0123", "NFOV_2X2BINNED", 30, lens, None, np.eye(4))
    flat = np.full((288, 320), 700, np.uint16)
    with Recorder(path, camera, fps=30, colour=False) as recorder:
        for n in range(60):
            recorder.write(Frame(n * PERIOD_US, flat, flat))


class Service:
    """A running service."""

    def __init__(self, folder: Path, *options: str, source: str = "", zenoh: str = "") -> None:
        """`options` of `halo serve`; `source`: instead of the recording; `zenoh`: where it
        listens, empty: without Zenoh."""
        self.control_port = free_port(socket.SOCK_DGRAM)
        self.web_port = free_port(socket.SOCK_STREAM)
        self.url = f"ws://127.0.0.1:{self.web_port}/halo"
        if not source:
            write_recording(folder / "table.mkv")
            options = (*options, "--loop")
        settings = folder / "halo.toml"
        settings.write_text(f"[web]\nport = {self.web_port}\nannounce = false\n")
        self._log = folder / "service.log"
        command = [str(Path(sys.executable).with_name("halo")), "serve", "--config", str(settings)]
        command += ["--source", source or f"recording:{folder / 'table.mkv'}", "--node", "good"]
        command += ["--control-port", str(self.control_port), *options]
        command += ["--zenoh-listen", zenoh] if zenoh else ["--no-zenoh"]
        with self._log.open("w") as log:
            self._process = subprocess.Popen(
                command, stderr=log, env={**os.environ, "XDG_DATA_HOME": str(folder)}
            )

    def __enter__(self) -> Self:
        until = time.monotonic() + START_S
        while "ready" not in self.log:
            if self._process.poll() is not None or time.monotonic() > until:
                self._process.kill()
                raise SystemExit(f"the service does not start:\n{self.log}")
            time.sleep(0.1)
        return self

    @property
    def log(self) -> str:
        """What it has logged."""
        return self._log.read_text(errors="replace")

    @property
    def running(self) -> bool:
        """Whether it has not ended."""
        return self._process.poll() is None

    def memory_mb(self) -> float:
        """Return the memory that it uses, in MB."""
        return memory_mb(self._process.pid)

    def stop(self) -> int:
        """End it as Ctrl-C does; return its exit code."""
        self._process.terminate()
        return self._process.wait(30.0)

    def __exit__(
        self, _: type[BaseException] | None, __: BaseException | None, ___: TracebackType | None
    ) -> None:
        self._process.kill()
        self._process.wait()


def memory_mb(pid: int | str = "self") -> float:
    """Return the resident memory of a process (Linux), in MB."""
    for line in Path(f"/proc/{pid}/status").read_text().splitlines():
        if line.startswith("VmRSS"):
            return int(line.split()[1]) / 1024
    return 0.0
