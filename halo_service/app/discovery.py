"""Finds running services: by mDNS and by Zenoh, on this machine and where the user opened it."""

from __future__ import annotations

import json
import time
from contextlib import closing
from typing import NamedTuple

import zenoh
from zeroconf import (
    InterfaceChoice,
    IPVersion,
    ServiceBrowser,
    ServiceInfo,
    ServiceStateChange,
    Zeroconf,
)

import halo_protocol as wire
from halo_service.errors import UserError
from halo_service.evaluation.report.table import Table
from halo_service.files import from_home
from halo_service.outputs.settings import LISTEN
from halo_service.settings import Settings
from halo_service.web.announcement import OSC

LOOK_S = 1.5
"""Time in which services answer."""
ANSWER_MS = 1000
"""The same for one service that was found by mDNS."""
MOST_NAMES = 1000
"""Announcements that are remembered; any program can send more."""


class Service(NamedTuple):
    """One running service."""

    node: str
    surface: str
    session: str
    rate_hz: float
    """Nominal frames per second; 0 if unknown."""
    by: str
    """`mdns` or `zenoh`."""
    address: str
    """Host and port for control messages, or the Zenoh key of its scene."""


def find_services(settings: Settings) -> list[Service]:
    """Look for a moment. Raises `UserError` where neither way can be used."""
    return sorted(_by_mdns() + (_by_zenoh(settings) if settings.zenoh.enabled else []))


def format_service(service: Service) -> str:
    """Return a service as one line."""
    *cells, by, address = _cells(service)
    return "  ".join((*cells, f"{by} {address}"))


def table_of(services: list[Service]) -> Table:
    """Return the services as a table."""
    head = ("node", "surface", "rate", "found by", "address")
    return Table("", head, tuple(map(_cells, services)))


def _cells(service: Service) -> tuple[str, ...]:
    node, surface, _, rate_hz, by, address = service
    return node, surface, f"{rate_hz:g} Hz", by, address


class MdnsSearch:
    """Finds what is announced, until it is closed."""

    def __init__(self) -> None:
        """Start to search. Raises `UserError` where mDNS cannot be used."""
        self._names: set[str] = set()
        try:
            self._browser = Zeroconf(interfaces=InterfaceChoice.All, ip_version=IPVersion.V4Only)
        except OSError as error:
            raise UserError(
                f"mdns: cannot look for services ({error.strerror or error})"
            ) from error
        ServiceBrowser(self._browser, OSC, handlers=[self._note])

    def services(self) -> list[Service]:
        """Ask what was found who it is; takes a second for each that does not answer."""
        infos = [self._browser.get_service_info(OSC, name, ANSWER_MS) for name in list(self._names)]
        return [each for info in infos if info and (each := _service(info)) is not None]

    def close(self) -> None:
        """End the search."""
        self._browser.close()

    def _note(self, zeroconf: Zeroconf, service_type: str, name: str, state_change: object) -> None:
        del zeroconf, service_type
        if state_change is ServiceStateChange.Removed:
            self._names.discard(name)
        elif len(self._names) < MOST_NAMES:
            self._names.add(name)


def _by_mdns() -> list[Service]:
    with closing(MdnsSearch()) as search:
        time.sleep(LOOK_S)
        return search.services()


def _service(info: ServiceInfo) -> Service | None:
    """Return an announced service; None for one of another program, or with invalid names."""
    facts = {key: value or "" for key, value in info.decoded_properties.items()}
    try:
        node = wire.check_name(facts["node"], "node")
        surface = wire.check_surface(facts["surface"])
        session = wire.check_session(facts["session"])
        rate_hz = float(facts["rate_hz"])
        host = info.parsed_addresses()[0]
    except (LookupError, ValueError):
        return None
    return Service(node, surface, session, rate_hz, "mdns", f"{host}:{info.port}")


def _by_zenoh(settings: Settings) -> list[Service]:
    """Ask every reachable service for its scene."""
    path = settings.zenoh.config
    endpoints = settings.zenoh.connect or (() if path else settings.zenoh.listen or LISTEN)
    try:
        config = zenoh.Config.from_file(from_home(path)) if path else zenoh.Config()
        for key, value in (
            ("mode", "client" if not settings.zenoh.multicast else "peer"),
            ("connect/endpoints", list(endpoints)),
            ("connect/timeout_ms", round(LOOK_S * 1000)),
            ("scouting/multicast/enabled", settings.zenoh.multicast),
        ):
            if value != []:  # the file names some
                config.insert_json5(key, json.dumps(value))
        session = zenoh.open(config)
    except zenoh.ZError:
        return []  # nothing listens there
    found: dict[str, Service] = {}
    with session:
        for reply in session.get("halo/1/*/*/scene", timeout=LOOK_S):
            service = _scene(reply)
            if service is not None:
                found[service.address] = service
    return list(found.values())


def _scene(reply: zenoh.Reply) -> Service | None:
    if reply.ok is None:
        return None
    try:
        messages = wire.decode(reply.ok.payload.to_bytes())
    except wire.ProtocolError:
        return None
    for surface, message in messages:
        if isinstance(message, wire.Scene):
            key = str(reply.ok.key_expr)
            return Service(message.node, surface, message.session, message.rate_hz, "zenoh", key)
    return None
