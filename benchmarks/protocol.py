"""What a frame costs to write and to read, compared with python-osc in the same run.

    python benchmarks/protocol.py

Absolute times are this machine's. Goals: 50 us for a frame, 150 us for all formats together.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from timeit import repeat

from pythonosc.osc_bundle import OscBundle
from pythonosc.osc_bundle_builder import IMMEDIATELY, OscBundleBuilder
from pythonosc.osc_message_builder import OscMessageBuilder

from halo_protocol import Assembler, Frame, Pointer, decode, encode_frame, parse_osc
from halo_service.outputs.destination import Stream
from halo_service.outputs.formats import make_format
from halo_service.outputs.outgoing import OutgoingFrame

HEADER = Frame("desk", "s1", 1, 1_700_000_000, 500_000, 10)
POINTERS = [
    Pointer(i, i, 2, 1, 1, 0.5, 0.25, 150.0, 50.0, 0.0, 0.5, 1.0, 2.0, 0.9, 3, -1.0)
    for i in range(10)
]
(DATAGRAM,) = encode_frame("table", HEADER, POINTERS, max_bytes=1432)
FRAME = OutgoingFrame("table", (300.0, 200.0), HEADER, tuple(POINTERS), (), ())
FORMATS = {name: make_format(Stream(name)) for name in ("flat", "tuio11", "tuio2")}
ARGUMENTS = parse_osc(DATAGRAM)
GOALS_US = {"write 10 pointers": 50.0, "write all formats": 150.0}


def theirs_written() -> bytes:
    """The same frame by python-osc's builders, types given, so that it need not guess them."""
    builder = OscBundleBuilder(IMMEDIATELY)
    for address, arguments in ARGUMENTS:
        message = OscMessageBuilder(address)
        for argument in arguments:
            kind = "s" if isinstance(argument, str) else "f" if isinstance(argument, float) else "i"
            message.add_arg(argument, kind)
        builder.add_content(message.build())
    return bytes(builder.build().dgram)


def theirs_read() -> int:
    """The same datagram by python-osc, as far as we go: addresses and values."""
    return sum(len(message.params) for message in OscBundle(DATAGRAM))


def best_us(action: Callable[[], object], number: int = 20) -> float:
    """The best of several runs: the cost on an idle machine."""
    return min(repeat(action, number=number, repeat=100)) / number * 1e6


def all_formats() -> int:
    """One frame in every format, as with four destinations."""
    datagrams = encode_frame("table", HEADER, POINTERS)
    return len(datagrams) + sum(len(each.frame(FRAME)) for each in FORMATS.values())


def main() -> int:
    """Print the table; 1 if a goal is missed."""
    if theirs_written() != DATAGRAM:
        raise SystemExit("the two wrote different bytes: there is nothing to compare")
    rows = [
        (
            "write 10 pointers",
            best_us(lambda: encode_frame("table", HEADER, POINTERS)),
            best_us(theirs_written),
        ),
        *(
            (f"write as {name}", best_us(lambda one=one: one.frame(FRAME)), best_us(theirs_written))
            for name, one in FORMATS.items()
        ),
        ("write all formats", best_us(all_formats), best_us(theirs_written)),
        ("read 10 pointers", best_us(lambda: decode(DATAGRAM)), best_us(theirs_read)),
        (
            "read and assemble",
            best_us(lambda: Assembler().receive_data(DATAGRAM, 0.0)),
            best_us(theirs_read),
        ),
    ]
    print(f"{len(DATAGRAM)} bytes        ours       python-osc   ratio")
    for name, ours, theirs in rows:
        print(f"{name:18} {ours:7.1f} us {theirs:9.1f} us {theirs / ours:6.1f}")
    ours_us = {name: ours for name, ours, _ in rows}
    return int(any(ours_us[name] > goal_us for name, goal_us in GOALS_US.items()))


if __name__ == "__main__":
    sys.exit(main())
