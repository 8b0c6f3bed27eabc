"""`halo-monitor`: shows what a halo service sends, in a terminal or as lines of JSON.

Rule: input and output only: it reads the clock and prints. `monitor_view` formats,
`halo_client` receives.
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
"""A file or pipe gets one picture per second; a terminal gets ten, each replacing the last."""
_PATIENCE_S = 2.0
"""Time without frames after which `--json` prints a message."""


def main(argv: list[str] | None = None) -> int:
    """Run the command; return 0, 1 if too few frames came, 2 if it cannot start."""
    parser = argparse.ArgumentParser(
        prog="halo-monitor",
        description="Show what a halo service sends: pointers, rates, latency, losses.",
    )
    add_arguments(parser)
    return run(parser.parse_args(argv))


def run(options: argparse.Namespace) -> int:
    """Show frames until the end set by the options; return the exit code of `main`."""
    logging.basicConfig(format="halo-monitor: %(message)s", level=logging.WARNING)
    try:
        with halo_client.connect(options.source, everything=True) as receiver:
            return _show(receiver, options)
    except ClientError as error:
        print(f"halo-monitor: {error}", file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        return 0
    except BrokenPipeError:
        # The reader closed the pipe. Without this, Python reports the error again when it flushes.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of the command; `halo monitor` shares them."""
    parser.add_argument(
        "--from",
        dest="source",
        default=halo_client.DEFAULT_SOURCE,
        metavar="URL",
        help="osc://127.0.0.1:4256 (default), osc://?hello=127.0.0.1:4257 (asks for the stream), "
        "ws://127.0.0.1:4258/halo, zenoh://?connect=tcp/127.0.0.1:7447 or FILE.jsonl",
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
            show.update(events, time.monotonic(), time.time_ns() // 1000)
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
    """Prints one line per event, flushed, so that a pipe gets it at once."""

    def __init__(self, out: TextIO) -> None:
        self._out = out
        self._warned = False

    def update(self, events: list[Event], now_s: float, unix_us: int) -> None:
        """Print events with their arrival time."""
        for event in events:
            line = {**event_to_json(event), "received_us": unix_us}
            print(json.dumps(line), file=self._out, flush=True)

    def patience(self, url: str, waited_s: float) -> None:
        """Print once to stderr that nothing has arrived yet."""
        if waited_s > _PATIENCE_S and not self._warned:
            self._warned = True
            print(waiting(url), file=sys.stderr, flush=True)

    def end(self) -> None:
        """Nothing to do."""


class Picture:
    """Draws the view again and again: in place on a terminal, one below the other in a pipe."""

    def __init__(self, out: TextIO, receiver: Receiver) -> None:
        self._out = out
        self._receiver = receiver
        self._view = View()
        self._drawn_s: float | None = None
        self._height = 0
        self._in_place = out.isatty()
        self._tick_s = _TICK_S if self._in_place else _PIPED_TICK_S

    def update(self, events: list[Event], now_s: float, unix_us: int) -> None:
        """Take in events; draw if it is time."""
        for event in events:
            self._view.update(event, now_s, unix_us)
        if self._drawn_s is None or now_s - self._drawn_s >= self._tick_s:
            self._draw(now_s)

    def end(self) -> None:
        """Draw the last picture."""
        self._draw(time.monotonic())

    def _draw(self, now_s: float) -> None:
        receiver = self._receiver
        lines = self._view.lines(receiver.url, receiver.services, receiver.losses, now_s)
        self._drawn_s = now_s
        if not self._in_place:
            print("\n".join([*lines, ""]), file=self._out, flush=True)
            return
        size = shutil.get_terminal_size()
        # Cut to the window: a wrapped line or a taller picture cannot be overwritten.
        lines = [line[: size.columns - 1] for line in lines[: size.lines - 1]]
        back = f"\x1b[{self._height}F" if self._height else ""
        print(f"{back}\x1b[J" + "\n".join(lines), file=self._out, flush=True)
        self._height = len(lines)


if __name__ == "__main__":
    sys.exit(main())
