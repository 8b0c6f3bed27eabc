"""Whether a router or service answers at an address, which one it is, and how fast.

Rule: each fault is one `Finding` with its remedy; the first fault of an address ends its checks.
"""

from __future__ import annotations

import json
import re
import socket
import statistics
import time
from collections.abc import Sequence
from contextlib import suppress

import zenoh

import halo_protocol as wire
from halo_client import ZenohSource
from halo_client.zenoh_input import zenoh_config
from halo_service.app.doctor import Finding
from halo_service.app.network.interfaces import Card
from halo_service.app.versions import zenoh_version
from halo_service.outputs.zenoh_session import reason

CONNECT_S = 2.0
OPENS = 4
"""Tries by UDP, where one lost packet ends a try."""
TRIPS = 20
"""Round trips that are measured."""
TRIP_S = 0.5
"""Time after which one counts as lost."""
SLOW_MS = 20.0
CERTIFICATES = (
    "compare the certificates on both sides: authority, addresses in them, dates; a router with "
    "RUST_LOG=zenoh=info in its environment reports why it refuses"
)
REFUSED = {
    "tls": CERTIFICATES,
    "quic": f"open this UDP port in the firewall there; {CERTIFICATES}",
    "udp": "start a router or service with a udp endpoint there, or open this UDP port in the "
    "firewall",
}
"""What to do where no session opens, by protocol."""
ENDPOINT = re.compile(r"^(\w+)/(.+):(\d+)([?#].*)?$")


def reach(source: ZenohSource, cards: Sequence[Card]) -> tuple[list[Finding], bool]:
    """Check the address of a source; also return whether a Zenoh session opens there."""
    try:
        endpoints = _endpoints(source)
    except zenoh.ZError as error:
        place = source.config or ", ".join(source.connect)
        remedy = "write endpoints as tcp/HOST:PORT, and a configuration as a JSON5 file"
        return [Finding(place, False, f"cannot be used ({reason(error)})", remedy)], False
    place = ", ".join(endpoints) or "multicast"
    for endpoint in endpoints if source.mode == "client" else ():
        fault = _fault(endpoint, cards)
        if fault is not None:
            return [fault], False
    try:
        session = _opened(source, OPENS if place.startswith("udp") else 1)
    except zenoh.ZError as error:
        return [_refused(place, reason(error))], False
    with session:
        return [_who(session, place), _trips(session, place)], True


def _opened(source: ZenohSource, times: int) -> zenoh.Session:
    """Open a session, in the last of some tries raising `ZError`."""
    for _ in range(times - 1):
        with suppress(zenoh.ZError):
            return zenoh.open(zenoh_config(source))
    return zenoh.open(zenoh_config(source))


def _endpoints(source: ZenohSource) -> list[str]:
    """Return the addresses of a source, or of its configuration."""
    endpoints = json.loads(zenoh_config(source).get_json("connect/endpoints"))
    return [each for each in endpoints if isinstance(each, str)]


def _fault(endpoint: str, cards: Sequence[Card]) -> Finding | None:
    """Return why nothing answers at the address; None if something does, or if that is unknown."""
    parts = ENDPOINT.match(endpoint)
    if parts is None:
        return None
    try:
        found = socket.getaddrinfo(parts[2].strip("[]"), int(parts[3]), type=socket.SOCK_STREAM)
        family, kind, number, _, address = found[0]
        if parts[1] not in ("tcp", "tls", "ws"):
            return None  # by UDP nothing answers but Zenoh itself
        with socket.socket(family, kind, number) as probe:
            probe.settimeout(CONNECT_S)
            probe.connect(address)
    except OSError as error:
        return Finding(endpoint, False, *_explained(error, parts[2], cards))
    return None


def _explained(error: OSError, host: str, cards: Sequence[Card]) -> tuple[str, str]:
    """Return what an error of a connection means, and the remedy."""
    if isinstance(error, socket.gaierror):
        return f"the name '{host}' is unknown here", "write the machine's address instead"
    if isinstance(error, ConnectionRefusedError):
        return (
            "the machine answers, but nothing listens at this port",
            "start the router or service there; a service can be reached from its own machine "
            "only, until [zenoh] listen says tcp/0.0.0.0:7447",
        )
    if isinstance(error, TimeoutError):
        return (
            f"no answer within {CONNECT_S:g} s",
            "compare the address; then open this port in the firewall of that machine, and look "
            "whether the Wi-Fi separates its clients",
        )
    networks = ", ".join(str(ip.network) for card in cards for ip in card.addresses)
    return (
        f"there is no way to it ({error.strerror or error})",
        f"this machine is in {networks or 'no network'}: connect to a router that is in one of "
        "them, or correct the address",
    )


def _refused(place: str, why: str) -> Finding:
    """Explain why no session opens, although a TCP port answers."""
    if why.startswith("Unable to connect"):
        why = "it does not answer as Zenoh"
    protocol = place.partition("/")[0]
    remedy = REFUSED.get(protocol, "another program may have the port there; or write tls/ for TLS")
    return Finding(place, False, f"no session opens ({why})", remedy)


def _who(session: zenoh.Session, place: str) -> Finding:
    """Say which Zenoh answers."""
    transports = list(session.info.transports())
    if not transports:
        return Finding(place, False, "connected to nothing", "start a router or service there")
    kinds = [str(each.whatami) for each in transports]
    who = "a router" if "router" in kinds else "a service or other peer"
    versions = _versions(session)
    if not versions:
        return Finding(place, True, f"{who} answers; it does not report its Zenoh version")
    text = f"{who} with Zenoh {', '.join(versions)} answers"
    others = [each for each in versions if _minor(each) != _minor(zenoh_version())]
    if not others:
        return Finding(place, True, text)
    remedy = f"this machine has Zenoh {zenoh_version()}: install the same minor version on both"
    return Finding(place, False, text, remedy)


def _versions(session: zenoh.Session) -> list[str]:
    """Return the Zenoh versions of the routers that report themselves."""
    versions = set()
    for reply in session.get("@/*/router", timeout=TRIP_S):
        if reply.ok is not None:
            try:
                version = str(json.loads(reply.ok.payload.to_bytes())["version"])
            except (ValueError, LookupError, TypeError):
                continue  # not a router's report
            versions.add(version.lstrip("v").partition("-")[0][:20])
    return sorted(versions)


def _trips(session: zenoh.Session, place: str) -> Finding:
    """Measure round trips to the router or service."""
    times_ms, lost = [], 0
    for _ in range(TRIPS):
        began_s = time.monotonic()
        list(session.liveliness().get(wire.liveliness_key(wire.ANY), timeout=TRIP_S))
        took_s = time.monotonic() - began_s
        if took_s < TRIP_S:
            times_ms.append(1000.0 * took_s)
        else:
            lost += 1
    what = f"round trip to {place}"
    if not times_ms:
        return Finding(
            what, False, "no answer", "the connection is too bad to be used; use a cable"
        )
    middle_ms = statistics.median(times_ms)
    state = f"{middle_ms:.1f} ms, at most {max(times_ms):.1f} ms" + (
        f", {lost} of {TRIPS} lost" if lost else ""
    )
    good = not lost and max(times_ms) <= SLOW_MS
    remedy = "a slow or lossy network; a cable is faster, and docs/networks.md has more for Wi-Fi"
    return Finding(what, good, state, remedy, optional=True)


def _minor(version: str) -> str:
    return ".".join(version.split(".")[:2])
