"""`halo conformance`: test a client with a scripted stream."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

import halo_protocol as wire
from halo_service.errors import UserError
from halo_service.files import read_text

SUMMARY = "test whether a client follows the protocol"
EXAMPLE = "halo conformance --osc 127.0.0.1:4256"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of the command."""
    what = parser.add_mutually_exclusive_group()
    what.add_argument(
        "--osc",
        default=f"127.0.0.1:{wire.DEFAULT_PORT}",
        metavar="HOST:PORT",
        help=f"send to a client that listens there (default 127.0.0.1:{wire.DEFAULT_PORT})",
    )
    what.add_argument(
        "--web", type=int, metavar="PORT", help="send to the first client of a WebSocket server"
    )
    what.add_argument(
        "--compare",
        metavar="FILE",
        help="compare a client's lines of JSON; - for stdin; sends nothing",
    )
    what.add_argument(
        "--expected",
        metavar="FILE",
        help="write a correct client's lines; - for stdout; sends nothing",
    )


def run(options: argparse.Namespace) -> int:
    """Send, compare or write; return 1 if the client differs."""
    if options.compare:
        return _compare(options.compare)
    if options.expected:
        return _write(options.expected)
    _play(options)
    print("sent. Compare what the client has written: halo conformance --compare FILE.jsonl")
    return 0


def _play(options: argparse.Namespace) -> None:
    from halo_service.app.conformance.play import play_udp, play_websocket
    from halo_service.app.conformance.script import steps
    from halo_service.outputs.destination import parse_destination

    seconds = f"{steps()[-1].at_s:.0f} s"
    if options.web is not None:
        if not 0 < options.web < 65536:
            raise UserError("conformance: --web needs a port from 1 to 65535")
        play_websocket(options.web, lambda url: print(f"waiting for a client of {url}", flush=True))
        return
    to = parse_destination(options.osc, "conformance")
    print(f"sending to {to.host}:{to.port} for {seconds}", flush=True)
    play_udp(to.host, to.port)


def _compare(name: str) -> int:
    from halo_service.app.conformance.expected import read_lines, verdict

    try:
        text = sys.stdin.read() if name == "-" else read_text(Path(name))
    except (OSError, ValueError) as error:
        raise UserError(f"conformance: cannot read {name} ({error})") from error
    found = verdict(read_lines(text, name))
    for node, rule, difference in found:
        print(f"{'FAIL' if difference else 'ok  '} {node}: {rule}")
        if difference:
            print(f"     {difference}")
    return int(any(difference for _, _, difference in found))


def _write(name: str) -> int:
    import json

    from halo_service.app.conformance.expected import expected
    from halo_service.app.files import written

    with written(name) as file:
        file.writelines(json.dumps(line) + "\n" for line in expected())
    return 0
