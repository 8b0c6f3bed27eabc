"""Where touches go: what a user may set."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class OscSettings:
    """`[osc]` in halo.toml."""

    enabled: bool = True
    destinations: tuple[str, ...] = ("127.0.0.1:9000",)
    """`host:port` of every client that frames are sent to by UDP."""


@dataclass(frozen=True, slots=True)
class ZenohSettings:
    """`[zenoh]` in halo.toml."""

    enabled: bool = True
    listen: tuple[str, ...] = ("tcp/127.0.0.1:7447",)
    """Endpoints to wait at; loopback unless the user says otherwise."""
    connect: tuple[str, ...] = ()
    """Endpoints of routers or peers to call."""
    multicast: bool = False
    """Find peers by multicast. Off: it is absent on many networks, and it leaves the machine."""
    config: str = ""
    """A Zenoh configuration file (JSON5) to start from, for TLS, access control and the like."""


@dataclass(frozen=True, slots=True)
class ControlSettings:
    """`[control]` in halo.toml: the port that clients talk to."""

    host: str = "127.0.0.1"
    port: int = 9001
