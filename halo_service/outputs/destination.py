"""Destinations of OSC, as the user writes them: `HOST:PORT/FORMAT,option=value`.

Rule: text in, frozen values out; nothing is opened and no name is looked up here.
"""

from __future__ import annotations

import ipaddress
import socket
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import halo_protocol as wire
from halo_service.errors import UserError

FORMATS = ("frames", "flat", "tuio11", "tuio2")
TUIO_PORT = 3333
MOST_HZ = 1000.0
EXAMPLE = f"127.0.0.1:{wire.DEFAULT_PORT}"


@dataclass(frozen=True, slots=True)
class Stream:
    """What a destination receives; destinations with equal streams share one encoder."""

    format: str = "frames"
    """One of `FORMATS`."""
    rate_hz: float = 0.0
    """At most so many frames per second; 0: all."""
    surface: str = ""
    """Only this surface; empty: all."""
    bundles: bool = True
    """False: each message is a datagram of its own, for readers without bundles."""
    changes: bool = False
    """`flat` only: send values that changed, and all of them once a second."""
    timetags: bool = False
    """`frames` only: the timetag is the frame's time instead of "immediately"."""


@dataclass(frozen=True, slots=True)
class Destination:
    """One receiver."""

    host: str
    """A name or an address; broadcast and multicast addresses are allowed."""
    port: int
    stream: Stream = Stream()
    ttl: int = 1
    """Multicast: how many networks a datagram may cross."""
    interface: str = ""
    """Multicast: name or IPv4 address of the network interface; empty: the system's choice."""

    def __str__(self) -> str:
        host = f"[{self.host}]" if ":" in self.host else self.host
        return f"{host}:{self.port}/{self.stream.format}"


def parse_destination(text: str, section: str = "osc") -> Destination:
    """Read a destination. Raises `UserError` with the remedy.

    `section`: `osc`, or `tuio`, where port 3333 and format `tuio11` are the defaults.
    """
    address, *options = text.split(",")
    place, _, name = address.partition("/")
    default = "tuio11" if section == "tuio" else "frames"
    host, port = _place(place, section, text)
    stream = Stream(_choice(name or default, FORMATS, "format", section, text))
    destination = Destination(host, port, stream)
    for option in options:
        destination = _with(destination, option.strip(), section, text)
    _check(destination.stream, section, text)
    return destination


def _check(stream: Stream, section: str, text: str) -> None:
    """Refuse an option that the format does not have."""
    formats = {
        "changes": ("flat",) if stream.changes else FORMATS,
        "timetags": ("frames",) if stream.timetags else FORMATS,
        "bundles": FORMATS if stream.bundles else ("frames", "flat"),
    }
    for option, possible in formats.items():
        if stream.format not in possible:
            raise UserError(
                f"{section}: {option} is an option of {' and '.join(possible)}, not of "
                f"{stream.format}, in '{text}'"
            )


def _place(place: str, section: str, text: str) -> tuple[str, int]:
    if section == "tuio" and ":" not in place.rpartition("]")[2]:
        place = f"{place}:{TUIO_PORT}"
    host, _, port = place.rpartition(":")
    if host and port.isdecimal() and not 0 < int(port) < 65536:
        raise UserError(f"{section}: port {port} is not from 1 to 65535, in '{text}'")
    if not host or not port.isdecimal():
        examples = f"{EXAMPLE} or {EXAMPLE}/flat,rate=30"
        if section == "tuio":
            examples = f"127.0.0.1:{TUIO_PORT} or 127.0.0.1:{TUIO_PORT}/tuio2"
        raise UserError(
            f"{section}: '{text}' is not a destination; write host:port, such as {examples}"
        )
    return host.strip("[]"), int(port)


def _with(destination: Destination, option: str, section: str, text: str) -> Destination:
    key, found, value = option.partition("=")
    if not found or key not in OPTIONS:
        raise UserError(
            f"{section}: unknown option '{option}' in '{text}'; choose from: "
            f"{', '.join(f'{each}=' for each in OPTIONS)}"
        )
    try:
        return OPTIONS[key](destination, value)
    except ValueError as error:
        raise UserError(f"{section}: {key} must be {error}, not '{value}', in '{text}'") from error


def _stream(**read: Callable[[str], Any]) -> Callable[[Destination, str], Destination]:
    ((name, reader),) = read.items()

    def apply(destination: Destination, value: str) -> Destination:
        stream = replace(destination.stream, **{name: reader(value)})
        return replace(destination, stream=stream)

    return apply


def _rate(value: str) -> float:
    try:
        rate_hz = float(value)
    except ValueError:
        rate_hz = -1.0
    if not 0.0 < rate_hz <= MOST_HZ:
        raise ValueError(f"a number of frames per second, up to {MOST_HZ:.0f}")
    return rate_hz


def _switch(value: str) -> bool:
    if value not in ("on", "off"):
        raise ValueError("on or off")
    return value == "on"


def _surface(value: str) -> str:
    try:
        return wire.check_surface(value)
    except wire.ProtocolError as error:
        raise ValueError("the name of a surface, such as table") from error


def _ttl(destination: Destination, value: str) -> Destination:
    if not value.isdecimal() or not int(value) < 256:
        raise ValueError("a whole number from 0 to 255")
    return replace(destination, ttl=int(value))


def _interface(destination: Destination, value: str) -> Destination:
    names = [name for _, name in socket.if_nameindex()]
    if value not in names and not _is_ipv4(value):
        raise ValueError(f"an IPv4 address of this machine or one of {', '.join(names)}")
    return replace(destination, interface=value)


def _is_ipv4(text: str) -> bool:
    try:
        ipaddress.IPv4Address(text)
    except ValueError:
        return False
    return True


def _choice(value: str, known: tuple[str, ...], what: str, section: str, text: str) -> str:
    if value not in known:
        raise UserError(
            f"{section}: unknown {what} '{value}' in '{text}'; choose from: {', '.join(known)}"
        )
    return value


OPTIONS: dict[str, Callable[[Destination, str], Destination]] = {
    "rate": _stream(rate_hz=_rate),
    "surface": _stream(surface=_surface),
    "bundles": _stream(bundles=_switch),
    "changes": _stream(changes=_switch),
    "timetags": _stream(timetags=_switch),
    "ttl": _ttl,
    "interface": _interface,
}
"""Option -> how it changes a destination; `ValueError` states what is allowed."""
