"""Frames to send."""

from __future__ import annotations

from dataclasses import replace

import halo_protocol as wire
from halo_service.outputs.outgoing import OutgoingFrame

SIZE_MM = (300.0, 200.0)
FRAME_US = 33_333
HOVERING = wire.Pointer(
    7, 0, 2, 1, 0, 0.5, 0.25, 150.0, 50.0, 8.5, 0.0, 30.0, -20.0, 0.9, 2, -1.0
)  # a right index finger
TOUCHING = replace(HOVERING, state=1, hover_mm=0.0, pressure=0.5, force_g=80.0, contacts=3)


def frame(
    number: int = 0,
    pointers: tuple[wire.Pointer, ...] = (),
    downs: tuple[wire.Down, ...] = (),
    ups: tuple[wire.Up, ...] = (),
    start_us: int = 1_700_000_000_000_000,
) -> OutgoingFrame:
    """A frame at 30 frames a second."""
    time_us = start_us + number * FRAME_US
    header = wire.Frame(
        "desk", "s1", number, *divmod(time_us, 1_000_000), len(pointers), number * 33
    )
    return OutgoingFrame("table", SIZE_MM, header, pointers, downs, ups)


def fingers(count: int) -> tuple[wire.Pointer, ...]:
    """Fingers with different ids and slots, each second one touching."""
    return tuple(
        replace(TOUCHING if n % 2 else HOVERING, id=100 + n, slot=n, u=n / 20) for n in range(count)
    )
