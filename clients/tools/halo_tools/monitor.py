"""`halo-monitor`: what a halo service says, in a terminal or as lines of JSON.

Rule: the rim. It reads the clock, prints, and knows when to end; what is shown is made in
`monitor_view`, what is received in `halo_client`.
"""

from __future__ import annotations

import argparse
import json
import logging
import os
import shutil
import sys
import time
from typing import TextIO

import halo_client
from halo_client import ClientError, Receiver, waiting
from halo_protocol import Event, TouchFrame, event_to_json
from halo_tools.monitor_view import View

_TICK_S = 0.1
_PIPED_TICK_S = 1.0
"""A file or a pipe gets a picture a second; a terminal ten, each over the last."""
_PATIENCE_S = 2.0
"""How long `--json` stays silent before it says that nothing comes."""


def main(argv: list[str] | None = None) -> int:
    """Run the command. 0: it ended as asked; 1: too few frames came; 2: it could not begin."""
    parser = argparse.ArgumentParser(
        prog="halo-monitor",
        description="Show what a halo service sends: pointers, rates, latency, losses.",
    )
    add_arguments(parser)
    return run(parser.parse_args(argv))


def run(options: argparse.Namespace) -> int:
    """Show what comes until the end that the options set; return the exit code of `main`."""
    logging.basicConfig(format="halo-monitor: %(message)s", level=logging.WARNING)
    try:
        with halo_client.receive(options.source) as receiver:
            return _show(receiver, options)
    except ClientError as error:
        print(f"halo-monitor: {error}", file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        return 0
    except BrokenPipeError:
        # Whoever read us has seen enough. Python would complain once more when it flushes.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of the command; `halo monitor` shares them."""
    parser.add_argument(
        "--from",
        dest="source",
        default=halo_client.DEFAULT_SOURCE,
        metavar="URL",
        help="osc://127.0.0.1:9000 (default), zenoh://?connect=tcp/127.0.0.1:7447 or FILE.jsonl",
    )
    parser.add_argument("--json", action="store_true", help="a line of JSON for each event")
    parser.add_argument("--frames", type=_positive_int, metavar="N", help="end after N frames")
    parser.add_argument("--seconds", type=_positive, metavar="S", help="end after S seconds")


def _positive(text: str) -> float:
    value = float(text)
    if not value > 0:
        raise argparse.ArgumentTypeError(f"must be more than 0, not {text}")
    return value


def _positive_int(text: str) -> int:
    value = int(text)
    if value < 1:
        raise argparse.ArgumentTypeError(f"must be at least 1, not {text}")
    return value


def _show(receiver: Receiver, options: argparse.Namespace) -> int:
    show = JsonLines(sys.stdout) if options.json else Picture(sys.stdout, receiver)
    began_s = time.monotonic()
    frames = 0
    try:
        while not receiver.ended and (options.frames is None or frames < options.frames):
            if options.seconds is not None and time.monotonic() - began_s >= options.seconds:
                break
            events = receiver.poll(_TICK_S)
            show.take(events, time.monotonic(), time.time_ns() // 1000)
            frames += sum(isinstance(event, TouchFrame) for event in events)
            if not frames and isinstance(show, JsonLines):
                show.patience(receiver.url, time.monotonic() - began_s)
    finally:
        show.end()
    if options.frames is not None and frames < options.frames:
        print(f"halo-monitor: {frames} of {options.frames} frames came", file=sys.stderr)
        return 1
    return 0


class JsonLines:
    """One line an event, flushed, so that a pipe reads live."""

    def __init__(self, out: TextIO) -> None:
        self._out = out
        self._told = False

    def take(self, events: list[Event], now_s: float, unix_us: int) -> None:
        """Print events that came at this time."""
        for event in events:
            line = {**event_to_json(event), "received_us": unix_us}
            print(json.dumps(line), file=self._out, flush=True)

    def patience(self, url: str, waited_s: float) -> None:
        """Say once, beside the lines, that nothing has come yet."""
        if waited_s > _PATIENCE_S and not self._told:
            self._told = True
            print(waiting(url), file=sys.stderr, flush=True)

    def end(self) -> None:
        """Nothing is left to print."""


class Picture:
    """A view drawn over and over: in place on a terminal, one below the other in a pipe."""

    def __init__(self, out: TextIO, receiver: Receiver) -> None:
        self._out = out
        self._receiver = receiver
        self._view = View()
        self._drawn_s: float | None = None
        self._height = 0
        self._in_place = out.isatty()
        self._tick_s = _TICK_S if self._in_place else _PIPED_TICK_S

    def take(self, events: list[Event], now_s: float, unix_us: int) -> None:
        """Remember events; draw when it is time to."""
        for event in events:
            self._view.take(event, now_s, unix_us)
        if self._drawn_s is None or now_s - self._drawn_s >= self._tick_s:
            self._draw(now_s)

    def end(self) -> None:
        """Leave the last picture as it is now."""
        self._draw(time.monotonic())

    def _draw(self, now_s: float) -> None:
        receiver = self._receiver
        lines = self._view.lines(receiver.url, receiver.services, receiver.losses, now_s)
        self._drawn_s = now_s
        if not self._in_place:
            print("\n".join([*lines, ""]), file=self._out, flush=True)
            return
        size = shutil.get_terminal_size()
        # A line that wraps, or a picture taller than the window, could not be drawn over.
        lines = [line[: size.columns - 1] for line in lines[: size.lines - 1]]
        back = f"\x1b[{self._height}F" if self._height else ""
        print(f"{back}\x1b[J" + "\n".join(lines), file=self._out, flush=True)
        self._height = len(lines)


if __name__ == "__main__":
    sys.exit(main())
