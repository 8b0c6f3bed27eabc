"""The model of bytes, messages and latencies: closed formulas, for `docs/scale.md`.

Rule: pure, and without the encoder: a test compares both. Bytes of Zenoh and TCP are constants that
were measured with one node; what they predict for other numbers of nodes is compared with what is
measured there.
"""

from __future__ import annotations

from dataclasses import dataclass

TIMETAG = 16
"""`#bundle` and the timetag."""
FRAME_HZ, REPORT_HZ = 30.0, 2.0
SCENE_HZ, HEALTH_HZ = 2.0, 1.0
UP_BYTES, DOWN_BYTES = 16, 60
"""Zenoh's bytes of a message: to the router, and from it, with the key and the router's timestamp.
Measured with one node."""
PACKET_BYTES = 66
"""Ethernet, IPv4 and TCP of each packet. A message is a packet, as it is express."""
ACK_SHARE = 0.5
"""Packets without data for each with data: TCP acknowledges every second one."""


def padded(length: int) -> int:
    """Return the bytes of an OSC string with so many characters."""
    return length + 4 - length % 4


def element(surface: str, kind: str, tags: int, arguments: int) -> int:
    """Return the bytes of a message in a bundle: size, address, type tags, arguments."""
    return 4 + padded(len(f"/halo/1/{surface}/{kind}")) + padded(1 + tags) + arguments


def frame_bytes(
    node: str, session: str, surface: str, pointers: int, downs: int = 0, ups: int = 0
) -> int:
    """Return the bytes of a frame that fits one bundle."""
    names = padded(len(node)) + padded(len(session))
    return (
        TIMETAG
        + element(surface, "frame", 7, names + 20)
        + downs * element(surface, "down", 7, 28)
        + ups * element(surface, "up", 6, 24)
        + pointers * element(surface, "pointer", 16, 64)
        + element(surface, "alive", pointers, 4 * pointers)
    )


def scene_bytes(node: str, session: str, surface: str, *versions: str) -> int:
    """Return the bytes of a scene; `versions`: of protocol, service and Zenoh."""
    names = sum(padded(len(each)) for each in (node, session, *versions))
    return TIMETAG + element(surface, "scene", 14, names + 36)


def health_bytes(node: str, session: str, surface: str) -> int:
    """Return the bytes of a health."""
    names = padded(len(node)) + padded(len(session))
    return TIMETAG + element(surface, "health", 22, names + 80)


def homography_bytes(node: str, session: str, surface: str) -> int:
    """Return the bytes of a homography."""
    names = padded(len(node)) + padded(len(session))
    return TIMETAG + element(surface, "homography", 14, names + 48)


def pose_bytes(node: str, session: str, surface: str) -> int:
    """Return the bytes of a pose."""
    names = padded(len(node)) + padded(len(session))
    return TIMETAG + element(surface, "pose", 28, names + 104)


@dataclass(frozen=True, slots=True)
class Stream:
    """What one node sends each second, or a sum of that over nodes."""

    messages: float
    payload: float
    """Bytes of halo's messages."""

    def times(self, count: float) -> Stream:
        """Return the stream of so many."""
        return Stream(self.messages * count, self.payload * count)

    def to_router(self) -> float:
        """Return the bytes a second in TCP, from nodes to a router."""
        return self.payload + self.messages * UP_BYTES

    def from_router(self) -> float:
        """Return the bytes a second in TCP, from a router to a subscriber."""
        return self.payload + self.messages * DOWN_BYTES

    def on_the_wire(self, tcp_bytes: float) -> float:
        """Return the bytes a second with the heads of packets and acknowledgements."""
        return tcp_bytes + self.messages * PACKET_BYTES * (1 + ACK_SHARE)


def frames_of(pointers: int, node: str = "n000", surface: str = "table") -> Stream:
    """Return the frames of one node."""
    return Stream(FRAME_HZ, FRAME_HZ * frame_bytes(node, "s1", surface, pointers))


def reports_of(node: str = "n000", surface: str = "table", *, placed: bool = False) -> Stream:
    """Return scene and health of one node; `placed`: homography and pose, too."""
    names = (node, "s1", surface)
    scene = SCENE_HZ * scene_bytes(*names, "1.0.0", "0.1.0", "1.10.2")
    stream = Stream(SCENE_HZ + HEALTH_HZ, scene + HEALTH_HZ * health_bytes(*names))
    if not placed:
        return stream
    more = REPORT_HZ * (homography_bytes(*names) + pose_bytes(*names))
    return Stream(stream.messages + 2 * REPORT_HZ, stream.payload + more)


def plus(a: Stream, b: Stream) -> Stream:
    """Return both together."""
    return Stream(a.messages + b.messages, a.payload + b.payload)


LEAF = 100
"""Nodes of one router."""
CANVAS = 10
"""Nodes that one canvas merges."""
ROUTER_US = 26.0
"""CPU of a router for a message that comes or goes, measured with 100 nodes."""


@dataclass(frozen=True, slots=True)
class Load:
    """What passes one router each second."""

    links: float
    messages: float
    """That come and go."""
    wire: float
    """Bytes, with the heads of packets, that come and go."""

    @property
    def cores(self) -> float:
        """CPU."""
        return self.messages * ROUTER_US / 1e6


@dataclass(frozen=True, slots=True)
class Plan:
    """A tree of routers: nodes and canvases at leaves, leaves and one watcher at the root."""

    surfaces: int
    routers: int
    leaf: Load
    root: Load | None
    """None where one router is enough."""
    watched: float
    """Messages a second that the watcher receives."""


def plan(surfaces: int, pointers: int = 2) -> Plan:
    """Return the tree for some surfaces. Each is read by one canvas, and watched."""
    each, report = plus(frames_of(pointers), reports_of()), reports_of()
    here = min(surfaces, LEAF)
    leaves = -(-surfaces // LEAF)
    read, watched = each.times(here), report.times(here)
    sent = plus(read, watched)
    leaf = Load(
        here + here / CANVAS + 1,
        read.messages + sent.messages,
        read.on_the_wire(read.to_router()) + sent.on_the_wire(sent.from_router()),
    )
    everything = report.times(surfaces)
    root = Load(
        leaves + 1,
        2 * everything.messages,
        2 * everything.on_the_wire(everything.from_router()),
    )
    if leaves == 1:
        return Plan(surfaces, 1, leaf, None, everything.messages)
    return Plan(surfaces, leaves + 1, leaf, root, everything.messages)
