"""Building blocks of the case tables."""

from __future__ import annotations

import struct
from collections.abc import Sequence
from dataclasses import dataclass, replace

from halo_protocol import (
    MAX_BUNDLE,
    Down,
    Finger,
    Frame,
    Hand,
    Message,
    Pointer,
    State,
    Up,
    encode_frame,
)
from halo_protocol.osc import IMMEDIATELY, bundle, message_spans, padded

TABLE = "table"
UNIX_S = 1_700_000_000
COUNTER = UNIX_S * 100 % 2**24


@dataclass(frozen=True)
class FrameCase:
    """A frame to be encoded, into one datagram or several."""

    name: str
    description: str
    header: Frame
    pointers: Sequence[Pointer] = ()
    downs: Sequence[Down] = ()
    ups: Sequence[Up] = ()
    surface: str = TABLE
    max_bytes: int = MAX_BUNDLE
    timetagged: bool = False

    def datagrams(self) -> list[bytes]:
        """The frame's bytes."""
        return encode_frame(
            self.surface,
            self.header,
            self.pointers,
            self.downs,
            self.ups,
            max_bytes=self.max_bytes,
            timetagged=self.timetagged,
        )


@dataclass(frozen=True)
class ReportCase:
    """A message in its own bundle."""

    name: str
    description: str
    message: Message
    time_us: int | None = None
    surface: str = TABLE


@dataclass(frozen=True)
class BytesCase:
    """A datagram that is only read: of another program, or malformed."""

    name: str
    description: str
    datagram: bytes


@dataclass(frozen=True)
class ControlCase:
    """A message between a client and the control port."""

    name: str
    description: str
    sender: str
    """`client` or `service`."""
    datagram: bytes


@dataclass(frozen=True)
class Step:
    """One thing that happens to an assembler."""

    at_s: float
    datagram: bytes | None = None
    """None: only advance the clock, with `expire`."""


@dataclass(frozen=True)
class AssemblyCase:
    """A sequence of datagrams."""

    name: str
    description: str
    steps: Sequence[Step]


def header(count: int, **changes: str | int) -> Frame:
    """A header with default values."""
    plain = Frame("desk", "s1", COUNTER, UNIX_S, 500_000, count, 1500)
    return replace(plain, **changes)  # type: ignore[arg-type]


def pointer(id: int = 7, slot: int = 0, **changes: float) -> Pointer:  # noqa: A002 - the wire's
    """A hovering right index finger, in numbers that a float32 holds exactly."""
    plain = Pointer(
        id=id,
        slot=slot,
        hand=Hand.RIGHT,
        finger=Finger.INDEX,
        state=State.HOVER,
        u=0.5,
        v=0.25,
        x_mm=150.0,
        y_mm=50.0,
        hover_mm=8.5,
        pressure=0.0,
        vx_mm_s=-12.5,
        vy_mm_s=40.0,
        confidence=0.875,
        contacts=0,
        force_g=-1.0,
    )
    return replace(plain, **changes)  # type: ignore[arg-type]


def touching(id: int = 7, slot: int = 0, contacts: int = 1, **changes: float) -> Pointer:  # noqa: A002
    """The same finger on the surface."""
    plain = pointer(id, slot, state=State.TOUCH, hover_mm=0.0, pressure=0.5, contacts=contacts)
    return replace(plain, **changes)  # type: ignore[arg-type]


def down(id: int = 7, contacts: int = 1, slot: int = 0, ago_ms: float = 12.5) -> Down:  # noqa: A002
    """A touch of that finger begins."""
    return Down(id, slot, 0.5, 0.25, 180.0, ago_ms, contacts)


def up(id: int = 7, contacts: int = 1, slot: int = 0, ago_ms: float = 4.0) -> Up:  # noqa: A002
    """A touch of that finger ends."""
    return Up(id, slot, 0.5, 0.25, ago_ms, contacts)


def hands(count: int) -> list[Pointer]:
    """Several fingers, no two alike."""
    return [
        pointer(
            100 + i,
            i,
            hand=Hand.LEFT if i % 10 < 5 else Hand.RIGHT,
            finger=i % 5,
            u=i / 64,
            x_mm=i / 64 * 300,
        )
        for i in range(count)
    ]


def message(address: str, tags: str, *arguments: bytes) -> bytes:
    """An OSC message of any kind."""
    return b"".join((padded(address), padded(f",{tags}"), *arguments))


def ints(*values: int) -> bytes:
    """Int32 arguments."""
    return struct.pack(f">{len(values)}i", *values)


def floats(*values: float) -> bytes:
    """Float32 arguments."""
    return struct.pack(f">{len(values)}f", *values)


UP_TAGS = "iifffi"


def raw_up(tags: str = UP_TAGS, id: int = 7, u: float = 0.5, rest: bytes = b"") -> bytes:  # noqa: A002
    """An up without a bundle, with values that `encode` refuses or does not support."""
    arguments = (ints(id, 0), floats(u, 0.25, 4.0), ints(1), rest)
    return message("/halo/1/table/up", tags, *arguments)


def now(*messages: bytes) -> bytes:
    """A bundle with the timetag "immediately"."""
    return bundle(IMMEDIATELY, *messages)


def bare(datagram: bytes) -> bytes:
    """The one message of a bundle."""
    return elements(datagram)[0]


def elements(datagram: bytes) -> list[bytes]:
    """The messages of a bundle."""
    return [datagram[start:end] for start, end in message_spans(datagram)]
