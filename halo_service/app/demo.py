"""`halo demo`: a guest on top of a virtual scenario that fits it, without a camera.

Rule: two programs are started as a user would start them, and neither is left behind: the one
that ends first, or Ctrl-C, ends the other.
"""

from __future__ import annotations

import argparse
import importlib.util
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Sequence
from dataclasses import dataclass

from halo_service.errors import UserError

TICK_S = 0.1
PATIENCE_S = 10.0
"""Time to end by itself, before a program is ended by force."""


@dataclass(frozen=True, slots=True)
class Show:
    """A guest and what it is played by."""

    module: str
    scenario: str
    options: tuple[str, ...]
    needs: tuple[str, ...]
    """Modules that come with the guest's extra."""


SHOWS = {
    "drums": Show("halo_drums.app", "sim:drumming", (), ("miniaudio", "pygame")),
    "paint": Show("halo_paint.app", "sim:painting", ("--vary",), ("numpy", "pygame")),
}


def main(argv: Sequence[str]) -> int:
    """Run a demo until its window is closed, or Ctrl-C; options unknown here are the guest's."""
    parser = argparse.ArgumentParser(
        prog="halo demo",
        description="A virtual hand plays, no camera needed. Other options go to the guest.",
    )
    parser.add_argument("guest", choices=SHOWS)
    parser.add_argument("--source", metavar="SIM", help="another scenario, e.g. sim:demo?seed=3")
    options, rest = parser.parse_known_args(argv)
    try:
        return demo(options.guest, options.source, rest)
    except UserError as error:
        print(f"halo: {error}", file=sys.stderr)
        return 2


def demo(name: str, source: str | None, rest: Sequence[str]) -> int:
    """Start both, and end both. Returns the guest's exit code, or the service's if it failed."""
    show = SHOWS[name]
    missing = [module for module in show.needs if importlib.util.find_spec(module) is None]
    if missing:
        raise UserError(
            f"the {name} need {', '.join(missing)}; `uv sync` brings it in a checkout, else "
            f"`uv pip install './clients[{name}]'`"
        )
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    signal.signal(signal.SIGINT, signal.default_int_handler)
    port, control = _free_ports()
    osc, scenario = f"127.0.0.1:{port}", source or show.scenario
    serve = ["serve", "--source", scenario, "--no-zenoh", "--osc", osc]
    serve += ["--control-port", str(control)]
    programs: list[subprocess.Popen[bytes]] = []
    try:
        programs.append(_start("halo_service.app.cli", *serve))
        programs.append(_start(show.module, "--from", f"osc://{osc}", *show.options, *rest))
        service, guest = programs
        while service.poll() is None and guest.poll() is None:
            time.sleep(TICK_S)
        return guest.returncode if service.returncode is None else service.returncode
    except KeyboardInterrupt:
        return 0
    finally:
        _end(programs)


def _start(module: str, *options: str) -> subprocess.Popen[bytes]:
    return subprocess.Popen([sys.executable, "-m", module, *options])


def _end(programs: list[subprocess.Popen[bytes]]) -> None:
    # A second Ctrl-C must not leave one of them behind.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    for program in programs:
        program.terminate()
    for program in programs:
        try:
            program.wait(PATIENCE_S)
        except subprocess.TimeoutExpired:
            program.kill()
            program.wait()


def _free_ports() -> tuple[int, int]:
    """Two UDP ports that nobody has, so that a service which runs already is not disturbed."""
    with (
        socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as one,
        socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as other,
    ):
        one.bind(("127.0.0.1", 0))
        other.bind(("127.0.0.1", 0))
        return int(one.getsockname()[1]), int(other.getsockname()[1])
