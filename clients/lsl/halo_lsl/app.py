"""`halo-lsl`: fingers as streams of the lab streaming layer.

Rule: input and output only. Frames and reports go to the pure part, with the clocks of their
arrival.
"""

from __future__ import annotations

import argparse
import logging
import signal
import sys
import time
from collections.abc import Sequence
from contextlib import ExitStack
from typing import TYPE_CHECKING

import halo_client
from halo_client import ClientError, Silence
from halo_lsl.bridge import Bridge
from halo_lsl.clock import Clock, Kind
from halo_lsl.errors import LslError
from halo_lsl.streams import Setup
from halo_window import add_source_option

if TYPE_CHECKING:
    from halo_lsl.outlets import Outlets

NAME = "halo-lsl"
DESCRIPTION = "Fingers on any table as streams of the lab streaming layer (LSL)."
EPILOG = """\
streams:
  halo-pointers   each finger's place, height, pressure, force and velocity, 30 times a second
  halo-contacts   each touch that begins or ends, at its own time
  halo-markers    the same as words (down/right/index), and what happens to the service

Times are on LSL's clock, of the camera's exposure: the delay of the pipeline is not in them.

examples:
  halo-lsl                     streams for the lab's network, as all LSL programs have them
  halo-lsl --local             for programs on this machine alone
  halo-lsl --from x.jsonl      a recorded stream, at its own speed
"""
POLL_S = 0.1
MOST_DELAY_MS = 10_000.0
"""A longer delay is a mistake in its unit."""


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command; return 0, or 2 if it cannot start."""
    options = _parser().parse_args(argv)
    logging.basicConfig(format=f"{NAME}: %(message)s", level=logging.WARNING)
    # Started in a shell's background, a program inherits that Ctrl-C is ignored.
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, signal.default_int_handler)
    try:
        with ExitStack() as stack:
            return _run(options, stack)
    except (ClientError, LslError, OSError) as error:
        print(f"{NAME}: {error}", file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        return 0


def _run(options: argparse.Namespace, stack: ExitStack) -> int:
    from halo_lsl.outlets import Outlets, configure, read_clocks

    configure(options.local)
    receiver = stack.enter_context(halo_client.connect(options.source))

    def create(setup: Setup) -> Outlets:
        outlets = stack.enter_context(Outlets(setup))
        where = "this machine alone" if options.local else "the network; --local keeps them here"
        _say(f"streams of {setup.node}/{setup.surface}, {setup.rate_hz:g} Hz, are on {where}")
        return outlets

    clock = Clock(Kind(options.clock), delay_s=options.delay / 1e3)
    bridge = Bridge(clock, create)
    silence = Silence(receiver.url, time.monotonic())
    while not receiver.ended:
        events = receiver.poll(POLL_S)
        now = read_clocks()
        for event in events:
            bridge.process(event, now)
        news = silence.notice(events, time.monotonic())
        if news and not receiver.ended:
            _say(news)
    if not bridge.created:
        raise ClientError(f"{receiver.url} has too few frames for a stream")
    return 0


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog=NAME,
        description=DESCRIPTION,
        epilog=EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    add_source_option(parser)
    parser.add_argument(
        "--local",
        action="store_true",
        help="let no other machine find the streams (LSL has no access control); a file named by "
        "LSLAPICFG decides instead",
    )
    parser.add_argument(
        "--clock",
        choices=[each.value for each in Kind],
        default=Kind.AUTO.value,
        help="how frame time becomes LSL time: by this machine's Unix clock (host), by the fastest "
        "arrivals (arrival), or what fits (auto, default)",
    )
    parser.add_argument(
        "--delay",
        type=_milliseconds,
        default=0.0,
        metavar="MS",
        help="for --clock arrival: delay of the fastest frame from exposure to arrival "
        "(%(default)g)",
    )
    return parser


def _milliseconds(text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = -1.0
    if not 0.0 <= value <= MOST_DELAY_MS:
        raise argparse.ArgumentTypeError(
            f"{text!r} is not a number from 0 to {MOST_DELAY_MS:g}, in milliseconds"
        )
    return value


def _say(text: str) -> None:
    print(f"{NAME}: {text}", file=sys.stderr, flush=True)


if __name__ == "__main__":
    sys.exit(main())
