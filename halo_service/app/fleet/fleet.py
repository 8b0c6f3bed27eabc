"""What is known of all nodes, from their scenes, healths, liveliness tokens and announcements.

Rule: pure and bounded; times are arguments. Frames are not needed, so a node costs three messages a
second, whatever its rate.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field

import halo_protocol as wire
from halo_service.app.discovery import Service
from halo_service.app.fleet.node import (
    LOST_S,
    Node,
    Versions,
    with_collisions,
    with_mismatches,
)
from halo_service.canvas.clocks import Clock

GONE_S = 30.0
"""How long a node that has gone is shown."""
MOST_NODES = 2000
"""Sessions that are remembered; beyond, the one that was quiet for longest is removed."""
FOREIGN = "other"
"""Session of a node of another major version, whose messages cannot be read."""

Key = tuple[str, str, str]
"""(node, surface, session)."""


@dataclass(slots=True)
class _Seen:
    """One session of a node on one surface."""

    first_s: float
    last_s: float
    """Arrival of the first and of the latest message."""
    scene: wire.Scene | None = None
    health: wire.Health | None = None
    major: str = ""
    """Only of a node of another major version."""
    clock: Clock = field(default_factory=Clock)


class Fleet:
    """Collects what arrives; `nodes` is what there is to show."""

    def __init__(self, here: Versions) -> None:
        """`here`: versions of this program, which count as those of one more node."""
        self._here = here
        self._seen: dict[Key, _Seen] = {}
        self._tokens: dict[str, float] = {}
        """Node -> when its token came."""
        self._announced: dict[Key, tuple[Service, float, float]] = {}
        """Service, first and last time; of mDNS."""

    def sample(self, key: str, payload: bytes, unix_us: int, now_s: float) -> None:
        """Note a Zenoh sample. `unix_us`: this machine's time when it arrived."""
        _, major, node, surface, *_ = key.split("/") + [""] * 4
        if major != key_major():
            self._foreign(node, surface, major, now_s)
            return
        try:
            messages = wire.decode(payload)
        except wire.ProtocolError:
            return  # any program can publish there
        for name, message in messages:
            if isinstance(message, wire.Scene):
                self._session(message.node, name, message.session, now_s).scene = message
            elif isinstance(message, wire.Health):
                seen = self._session(message.node, name, message.session, now_s)
                seen.health = message
                if message.time_s:
                    sent_us = message.time_s * 1_000_000 + message.time_frac_us
                    seen.clock.arrived(sent_us, unix_us)

    def token(self, key: str, *, alive: bool, now_s: float) -> None:
        """Note that a node's liveliness token came or went."""
        node = key.split("/")[2] if key.count("/") == 3 else ""
        if alive and len(self._tokens) < MOST_NODES and _is_name(node):
            self._tokens.setdefault(node, now_s)
        elif not alive:
            self._tokens.pop(node, None)

    def announced(self, services: Iterable[Service], now_s: float) -> None:
        """Note what is announced by mDNS now."""
        for each in list(services)[:MOST_NODES]:
            key = (each.node, each.surface, each.session)
            _, first_s, _ = self._announced.get(key, (each, now_s, now_s))
            self._announced[key] = (each, first_s, now_s)

    def nodes(self, now_s: float, unix_s: float) -> list[Node]:
        """Return all nodes by name, with their warnings; forget those that went long ago."""
        self._forget(now_s)
        found = [self._node(key, seen, now_s, unix_s) for key, seen in self._seen.items()]
        found += [
            _of_announcement(service, first_s, last_s, now_s)
            for key, (service, first_s, last_s) in self._announced.items()
            if key not in self._seen
        ]
        named = {each.node for each in found}
        found += [_of_token(node, now_s) for node in self._tokens if node not in named]
        running = {_place(each) for each in found if each.state in ("running", "announced")}
        shown = [
            each
            for each in found  # the last session of a node that was restarted is not shown
            if each.state in ("running", "announced") or _place(each) not in running
        ]
        warned = with_mismatches(with_collisions(shown), self._here)
        return sorted(warned, key=lambda each: (*_place(each), each.first_s))

    def _session(self, node: str, surface: str, session: str, now_s: float) -> _Seen:
        key = (node, surface, session)
        seen = self._seen.get(key)
        if seen is None:
            if len(self._seen) >= MOST_NODES:
                del self._seen[min(self._seen, key=lambda each: self._seen[each].last_s)]
            seen = self._seen[key] = _Seen(now_s, now_s)
        seen.last_s = now_s
        return seen

    def _foreign(self, node: str, surface: str, major: str, now_s: float) -> None:
        if _is_name(node) and _is_name(surface) and major.isascii() and major.isdecimal():
            self._session(node, surface, FOREIGN, now_s).major = major[:4]

    def _forget(self, now_s: float) -> None:
        old = [key for key, seen in self._seen.items() if now_s - seen.last_s > GONE_S + LOST_S]
        for key in old:
            del self._seen[key]
        for key in [key for key, each in self._announced.items() if now_s - each[2] > GONE_S]:
            del self._announced[key]

    def _node(self, key: Key, seen: _Seen, now_s: float, unix_s: float) -> Node:
        node, surface, session = key
        scene, health = seen.scene, seen.health
        announced = self._announced.get(key)
        quiet_s = now_s - seen.last_s
        return Node(
            node,
            surface,
            session,
            state=self._state(node, quiet_s),
            by="both" if announced else "zenoh",
            address=announced[0].address if announced else "",
            first_s=seen.first_s,
            last_s=seen.last_s,
            rate_hz=scene.rate_hz if scene else None,
            calibrated_age_s=_age_s(scene, unix_s),
            versions=_versions(scene, seen.major),
            collision=bool(scene and scene.collision),
            fps=health.fps if health else None,
            latency_ms=health.latency_ms if health and health.latency_ms >= 0.0 else None,
            clock_ms=_ahead_ms(seen.clock, health),
            camera=_word(wire.Camera, health.camera) if health else "",
            profile_fit=_word(wire.ProfileFit, health.profile_fit) if health else "",
        )

    def _state(self, node: str, quiet_s: float) -> str:
        if quiet_s <= LOST_S:
            return "running"
        return "silent" if node in self._tokens else "gone"


def _ahead_ms(clock: Clock, health: wire.Health | None) -> float | None:
    """Return the node's clock minus this machine's; too small by the shortest delay of the way."""
    if clock.fit is None or health is None:
        return None
    return -clock.fit.delay_at(health.time_s * 1_000_000) / 1000


def key_major() -> str:
    """Return the major version of our keys."""
    return wire.VERSION.partition(".")[0]


def _place(node: Node) -> tuple[str, str]:
    return node.node, node.surface


def _of_announcement(service: Service, first_s: float, last_s: float, now_s: float) -> Node:
    return Node(
        service.node,
        service.surface,
        service.session,
        state="announced" if now_s - last_s <= 2 * LOST_S else "gone",
        by="mdns",
        address=service.address,
        first_s=first_s,
        last_s=last_s,
        rate_hz=service.rate_hz,
    )


def _of_token(node: str, now_s: float) -> Node:
    """Return a node that is connected and sends nothing that we may read."""
    return Node(node, "", "", state="silent", by="zenoh", first_s=now_s, last_s=now_s)


def _versions(scene: wire.Scene | None, major: str) -> Versions:
    if scene is None:
        return Versions(major, "", "")
    return Versions(scene.version, scene.service_version, scene.zenoh_version)


def _age_s(scene: wire.Scene | None, unix_s: float) -> float | None:
    return unix_s - scene.calibrated_s if scene and scene.calibrated_s else None


def _word(kind: type[wire.Camera] | type[wire.ProfileFit], number: int) -> str:
    """Return the word of an enumeration number; of a later version's, the number."""
    try:
        return kind(number).name.lower()
    except ValueError:
        return str(number)


def _is_name(text: str) -> bool:
    try:
        wire.check_name(text, "node")
    except wire.ProtocolError:
        return False
    return True
