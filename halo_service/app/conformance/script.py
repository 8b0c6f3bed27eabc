"""The scripted stream: sections that each test one rule of the specification.

Rule: pure, and the same every time. A section is a service, and sections follow each other. What
one session shows does not depend on whether a limit (0.5 s, 3 s) is noticed some 0.1 s later, so a
slow machine changes nothing.
"""

from __future__ import annotations

import struct
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import halo_protocol as wire
from halo_protocol.osc import IMMEDIATELY, bundle, padded

STEP_S = 0.05
"""Time between two frames."""
REST_S = 4.0
"""Silence at the end, in which the last services are lost."""
HOVERING = wire.Pointer(
    7, 0, 2, 1, 0, 0.5, 0.25, 150.0, 50.0, 8.5, 0.0, 30.0, -20.0, 0.875, 0, -1.0
)


@dataclass(frozen=True, slots=True)
class Step:
    """A datagram and when it is sent, in seconds from the start; None: nothing, only time."""

    at_s: float
    datagram: bytes | None


@dataclass(frozen=True, slots=True)
class Section:
    """One rule: its sentence and its datagrams, in groups that are sent together."""

    name: str
    rule: str
    groups: list[list[bytes]]


def touching(contacts: int = 1, number: int = 7) -> wire.Pointer:
    """A finger that touches."""
    return replace(HOVERING, id=number, state=1, hover_mm=0.0, pressure=0.5, contacts=contacts)


def down(contacts: int = 1, ago_ms: float = 12.5) -> wire.Down:
    """Its down."""
    return wire.Down(7, 0, 0.5, 0.25, 180.0, ago_ms, contacts)


def up(contacts: int = 1, ago_ms: float = 4.0) -> wire.Up:
    """Its up."""
    return wire.Up(7, 0, 0.5, 0.25, ago_ms, contacts)


def hands(count: int) -> list[wire.Pointer]:
    """Many hovering fingers."""
    return [replace(HOVERING, id=100 + n, slot=n, u=n / 64) for n in range(count)]


def frame(
    node: str,
    number: int,
    pointers: Sequence[wire.Pointer] = (),
    events: Sequence[wire.Down | wire.Up] = (),
    session: str = "s1",
) -> list[bytes]:
    """The datagrams of a frame."""
    time_us = number * round(STEP_S * 1e6)
    time = divmod(1_700_000_000_000_000 + time_us, 1_000_000)
    header = wire.Frame(node, session, number, *time, len(pointers), time_us // 1000 % 2**24)
    downs = [event for event in events if isinstance(event, wire.Down)]
    ups = [event for event in events if isinstance(event, wire.Up)]
    return wire.encode_frame("table", header, pointers, downs, ups)


def tap(node: str) -> list[list[bytes]]:
    """A finger comes, touches, and leaves; each event is sent three times."""
    lifted = replace(HOVERING, contacts=1)
    return [
        frame(node, 1),
        frame(node, 2, [HOVERING]),
        *(frame(node, 3 + n, [touching()], [down(ago_ms=12.5 + 50 * n)]) for n in range(3)),
        *(frame(node, 6 + n, [lifted], [up(ago_ms=4.0 + 50 * n)]) for n in range(3)),
        frame(node, 9),
    ]


def loss() -> list[list[bytes]]:
    """All copies of a down are lost, then one of the next down and the up."""
    return [
        frame("loss", 1, [HOVERING]),
        frame("loss", 5, [touching()]),
        frame("loss", 8, [replace(HOVERING, contacts=1)]),
        frame("loss", 10, [touching(2)], [down(2, 62.5)]),
        frame("loss", 15),
    ]


def double() -> list[list[bytes]]:
    """Each datagram comes twice."""
    return [2 * group for group in tap("double")]


def reorder() -> list[list[bytes]]:
    """A frame overtakes another, and the counter wraps."""
    last = 2**24 - 1
    numbers = [last - 3, last - 1, last - 2, last, 0, last, 1]
    return [frame("reorder", n, [HOVERING]) for n in numbers]


def split() -> list[list[bytes]]:
    """Frames of two parts: in order, backwards, and with a lost part."""
    frames = [frame("split", n, hands(12)) for n in (1, 2, 3, 4)]
    return [frames[0], frames[1][::-1], frames[2][:1], frames[3]]


def restart() -> list[list[bytes]]:
    """A service is killed during a touch and starts again with a smaller number."""
    old = [frame("restart", 500 + n, [touching()], [down()]) for n in range(3)]
    return [*old, *(frame("restart", 100 + n, session="s2") for n in range(20))]


def two_nodes() -> list[list[bytes]]:
    """Two services send at the same time; their fingers have the same ids."""
    pairs = zip(tap("left"), [frame("right", n, [HOVERING]) for n in range(9)], strict=True)
    return [[*left, *right] for left, right in pairs]


def collision() -> list[list[bytes]]:
    """Two running services have one name."""
    return [
        [*frame("collision", n), *frame("collision", n + 40, [HOVERING], session="s2")]
        for n in range(20)
    ]


def many() -> list[list[bytes]]:
    """64 pointers are a frame; 100 are refused, and change nothing."""
    hundred = [_crowded(2, 100)]
    return [frame("many", 1, hands(64)), hundred, frame("many", 3, hands(64)), frame("many", 4)]


def _crowded(number: int, count: int) -> bytes:
    """A frame with more pointers than are allowed, which our writer refuses."""
    head = padded(wire.address("table", "frame")) + padded(",ssiiiii")
    numbers = struct.pack(">5i", number, 1_700_000_000, 0, count, 0)
    alive = padded(wire.address("table", "alive")) + padded("," + "i" * count)
    ids = struct.pack(f">{count}i", *range(100, 100 + count))
    return bundle(IMMEDIATELY, head + padded("many") + padded("s1") + numbers, alive + ids)


def other_major() -> list[list[bytes]]:
    """Another major version is another protocol: nothing of it is shown."""
    groups = [frame("major", n, [HOVERING]) for n in range(5)]
    return [[raw.replace(b"/halo/1/", b"/halo/2/") for raw in group] for group in groups]


def strangers() -> list[list[bytes]]:
    """Other programs' messages and half datagrams come between the frames."""
    (whole,) = frame("strangers", 2, [HOVERING])
    other = [padded("/other") + padded(",f") + struct.pack(">f", 1.0)]
    return [
        frame("strangers", 1, [HOVERING]),
        [b"hello"],
        [whole[:-8]],
        other,
        [bundle(IMMEDIATELY, other[0])],
        frame("strangers", 3, [HOVERING]),
    ]


_SECTIONS: dict[str, tuple[str, Callable[[], list[list[bytes]]]]] = {
    "plain": ("each touch is shown once", lambda: tap("plain")),
    "loss": ("lost events are inferred, lost frames are counted", loss),
    "double": ("a datagram that comes twice changes nothing", double),
    "reorder": ("a frame that is not newer is dropped; 0 comes after 2^24 - 1", reorder),
    "split": ("parts are put together in any order; a lost part leaves its fingers", split),
    "restart": ("a new session starts afresh; the old finger ends within a second", restart),
    "left": ("two services do not delete each other's pointers", two_nodes),
    "collision": ("two running services with one name are reported once", collision),
    "many": ("64 pointers are shown; a frame of 100 is refused whole", many),
    "major": ("another major version is ignored", other_major),
    "strangers": ("messages of others and broken datagrams are skipped", strangers),
}


def sections() -> list[Section]:
    """All sections, in the order in which they are sent."""
    return [Section(name, rule, groups()) for name, (rule, groups) in _SECTIONS.items()]


def steps() -> list[Step]:
    """All datagrams with their times."""
    groups = [group for section in sections() for group in section.groups]
    found = [Step(n * STEP_S, raw) for n, group in enumerate(groups) for raw in group]
    return [*found, Step(len(groups) * STEP_S + REST_S, None)]


def rules() -> dict[str, str]:
    """Node -> the rule that its frames test."""
    return {name: rule for name, (rule, _) in _SECTIONS.items()} | {"right": _SECTIONS["left"][0]}
