"""What MIDI adds to a frame: from its datagram to the last MIDI message of it.

uv run python benchmarks/midi.py [SECONDS]

A second process sends frames 30 times a second, with fingers that move and press. `halo-midi`'s
own loop receives them; the port only counts bytes, so that no driver is measured. A serial MIDI
cable carries 3.1 bytes a ms, which the last column compares with what one frame has.
"""

from __future__ import annotations

import math
import socket
import subprocess
import sys
import time
from collections.abc import Iterable
from contextlib import suppress
from typing import Any

import halo_client
from halo_midi.layouts import board
from halo_midi.player import Player
from halo_midi.port import MidiPort
from halo_protocol import Down, Frame, Pointer, TouchFrame, encode_frame
from halo_window import listen

FRAME_S = 1 / 30
SERIAL_BYTES_MS = 3.125
COUNTS = (1, 5, 10)
SENDER = "send"


class Ports:
    """A port that counts bytes."""

    def __init__(self) -> None:
        self.bytes = 0

    def get_output_names(self) -> list[str]:
        """The only one."""
        return ["benchmark"]

    def open_output(self, name: str, *, virtual: bool = False) -> Any:
        """Itself."""
        return self

    def send(self, message: Any) -> None:
        """Count a message."""
        self.bytes += len(message.bytes())

    def close(self) -> None:
        """Nothing is open."""


def main() -> None:
    """Measure one after the other."""
    if sys.argv[1:2] == [SENDER]:
        send(int(sys.argv[2]), int(sys.argv[3]), float(sys.argv[4]))
        return
    seconds = float(sys.argv[1]) if len(sys.argv) > 1 else 10.0
    print("fingers  sent -> MIDI, ms         received -> MIDI, ms     of a frame  on a cable, ms")
    for count in COUNTS:
        measure(count, seconds)


def measure(count: int, seconds: float) -> None:
    """Print a row."""
    ports, player = Ports(), Player(board("grid"))
    whole_ms: list[float] = []
    own_ms: list[float] = []
    sizes: list[int] = []
    with (
        halo_client.connect("osc://127.0.0.1:0") as receiver,
        MidiPort("benchmark", player.opening, player.closing, ports) as output,
    ):
        number = receiver.url.rpartition(":")[2]
        command = [sys.executable, __file__, SENDER, number, str(count), str(seconds)]
        sender = subprocess.Popen(command)

        def on_frame(frame: TouchFrame, now_s: float) -> None:
            before = ports.bytes
            output.send(lambda: [each.message for each in player.process(frame)])
            done_s = time.monotonic()
            own_ms.append(1e3 * (done_s - now_s))
            whole_ms.append(1e3 * done_s - frame.time_us / 1e3)
            sizes.append(ports.bytes - before)

        def draw(now_s: float, note: str) -> None:
            if sender.poll() is not None:
                raise KeyboardInterrupt

        with suppress(KeyboardInterrupt):
            listen("benchmark", receiver, None, on_frame, draw, at_once=True)
    share = median(own_ms) / (1e3 * FRAME_S)
    cable_ms = median([float(each) for each in sizes]) / SERIAL_BYTES_MS
    print(
        f"{count:7}  {spread(whole_ms):23}  {spread(own_ms):23}  {share:10.2%}  {cable_ms:6.1f}",
        flush=True,
    )


def send(port: int, count: int, seconds: float) -> None:
    """Send frames; their time is the monotonic clock, which both processes share."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as out:
        started_s = time.monotonic()
        for number in range(round(seconds / FRAME_S)):
            time.sleep(max(0.0, started_s + number * FRAME_S - time.monotonic()))
            now = divmod(time.monotonic_ns() // 1000, 1_000_000)
            fingers = [pointer(each, number) for each in range(count)]
            downs = [Down(each.id, each.slot, each.u, each.v, 200.0, 5.0, 1) for each in fingers]
            header = Frame("bench", "s1", number, *now, count)
            for datagram in encode_frame(
                "table", header, fingers, downs if number == 1 else [], []
            ):
                out.sendto(datagram, ("127.0.0.1", port))


def pointer(finger: int, number: int) -> Pointer:
    """A finger that circles and presses; it touches from frame 1 on."""
    angle = number / 15 + finger
    u, v = 0.1 + 0.08 * finger + 0.02 * math.sin(angle), 0.5 + 0.03 * math.cos(angle)
    pressure = 0.7 + 0.5 * math.sin(angle)
    state, contacts = (1, 1) if number else (0, 0)
    place = (u, v, 300.0 * u, 200.0 * v, 0.0, pressure if state else 0.0, 0.0, 0.0, 0.9)
    return Pointer(finger, finger, 2, 1, state, *place, contacts, -1.0)


def spread(values: list[float]) -> str:
    """Median and 99th percentile."""
    ordered = sorted(values)
    return f"{median(ordered):.2f} median, {ordered[int(0.99 * (len(ordered) - 1))]:.2f} p99"


def median(values: Iterable[float]) -> float:
    """The middle one."""
    ordered = sorted(values)
    return ordered[len(ordered) // 2]


if __name__ == "__main__":
    main()
