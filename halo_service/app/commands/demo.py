"""`halo demo`: a client and a virtual scenario that fits it, without a camera.

Rule: the service and the client are started as a user would start them. The one that ends first,
or Ctrl-C, ends the other.
"""

from __future__ import annotations

import argparse
import importlib.util
import signal
import socket
import subprocess
import sys
import threading
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass

from halo_service.app.process import stop_on_signals
from halo_service.errors import UserError

SUMMARY = "try drums, MIDI, paint or type with virtual hands instead of a camera"
EXAMPLE = "halo demo drums"

TICK_S = 0.1
PATIENCE_S = 10.0
"""Time to end by itself; after that a program is killed."""


HELP = "from {package}.command import main; raise SystemExit(main(['--help']))"
"""Prints a client's help, or which library it misses."""


@dataclass(frozen=True, slots=True)
class Demo:
    """A client and the scenario that it gets."""

    module: str
    scenario: str
    options: tuple[str, ...]
    needs: tuple[str, ...]
    """Modules that come with the extra of the client."""
    seeded: bool = False
    """Whether the client gets the seed of the scenario, which gives a typist its phrases."""


DEMOS = {
    "drums": Demo("halo_drums.app", "sim:drumming", (), ("miniaudio", "pygame")),
    "midi": Demo("halo_midi.app", "sim:demo", (), ("mido", "pygame", "rtmidi")),
    "paint": Demo("halo_paint.app", "sim:painting", ("--vary",), ("numpy", "pygame")),
    "type": Demo(
        "halo_type.app", "sim:typing", ("--pause", "1.6"), ("miniaudio", "numpy", "pygame"), True
    ),
}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of the command; the client gets every other option."""
    parser.set_defaults(forwards_options=True)
    parser.add_argument(
        "-h", "--help", action=_Help, help="show this help and the client's options"
    )
    parser.add_argument(
        "client",
        choices=tuple(DEMOS),
        metavar="CLIENT",
        help=f"{', '.join(DEMOS)}; it gets all other options; 'halo demo drums --help' shows them",
    )
    parser.add_argument("--source", metavar="SIM", help="another scenario, e.g. sim:demo,seed=3")


class _Help(argparse.Action):
    """Prints the help, and that of the client if one is named before."""

    def __init__(self, option_strings: Sequence[str], dest: str, help: str) -> None:  # noqa: A002
        super().__init__(option_strings, dest, nargs=0, default=argparse.SUPPRESS, help=help)

    def __call__(
        self,
        parser: argparse.ArgumentParser,
        namespace: argparse.Namespace,
        values: object,
        option_string: str | None = None,
    ) -> None:
        parser.print_help()
        chosen = DEMOS.get(getattr(namespace, "client", None) or "")
        if chosen is not None:
            print(f"\noptions of the client, which 'halo demo {namespace.client}' passes on:\n")
            sys.stdout.flush()
            script = HELP.format(package=chosen.module.partition(".")[0])
            subprocess.run([sys.executable, "-c", script], check=False)
        parser.exit()


def run(options: argparse.Namespace) -> int:
    """Run a demo until its window is closed, or Ctrl-C."""
    return demo(options.client, options.source, options.rest)


def demo(name: str, source: str | None, rest: Sequence[str]) -> int:
    """Start both, and end both. Return the exit code of the client, or of a service that failed."""
    chosen = DEMOS[name]
    missing = [module for module in chosen.needs if importlib.util.find_spec(module) is None]
    if missing:
        raise UserError(
            f"demo: '{name}' needs {', '.join(missing)}: run 'uv sync' in a checkout, or "
            f"'uv pip install ./clients[{name}]'"
        )
    # Not as an exception: between the start of a program and the note of it, it would be forgotten.
    stopped = threading.Event()
    stop_on_signals(stopped.set)
    port, control = _free_ports()
    osc, scenario = f"127.0.0.1:{port}", source or chosen.scenario
    options = (*chosen.options, *(_seed(scenario) if chosen.seeded else ()))
    serve = ["serve", "--source", scenario, "--no-zenoh", "--osc", osc]
    serve += ["--control-port", str(control)]
    programs: list[subprocess.Popen[bytes]] = []
    try:
        programs.append(_start("halo_service.app", *serve))
        print("demo: the service starts; the first time it measures its table", file=sys.stderr)
        if _sends(port, programs[0], stopped):
            print(f"demo: the service sends; {name} starts", file=sys.stderr)
            client = ("--from", f"osc://{osc}", *options, *rest)
            programs.append(_start(chosen.module, *client))
        while not stopped.is_set() and all(each.poll() is None for each in programs):
            stopped.wait(TICK_S)
        ended = [each.returncode for each in programs if each.returncode is not None]
        return ended[0] if ended and not stopped.is_set() else 0
    finally:
        _end(programs)


def _seed(scenario: str) -> tuple[str, ...]:
    from halo_service.virtual.sim_url import parse_sim_url  # heavy

    if scenario.partition(":")[0] != "sim":
        return ()
    return "--seed", str(parse_sim_url(scenario).room.seed)


def _sends(port: int, service: subprocess.Popen[bytes], stopped: threading.Event) -> bool:
    """Wait until the service sends, so that the client need not say that nothing comes."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as client:
        client.bind(("127.0.0.1", port))
        client.settimeout(TICK_S)
        while service.poll() is None and not stopped.is_set():
            with suppress(TimeoutError):
                client.recv(65_536)
                return True
    return False


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
    """Return two free UDP ports, so that a service that runs already is not disturbed."""
    with (
        socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as one,
        socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as other,
    ):
        one.bind(("127.0.0.1", 0))
        other.bind(("127.0.0.1", 0))
        return int(one.getsockname()[1]), int(other.getsockname()[1])
