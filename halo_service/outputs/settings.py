"""Where touches go: what a user may set."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

from annotated_types import Interval


@dataclass(frozen=True, slots=True)
class OscSettings:
    """`[osc]` in halo.toml."""

    enabled: bool = True
    destinations: tuple[str, ...] = ("127.0.0.1:9000",)
    """`host:port` of every client that frames are sent to by UDP."""


LISTEN = ("tcp/127.0.0.1:7447",)
"""Where the Zenoh peer waits if nobody says otherwise: Zenoh's own port, on loopback alone."""


@dataclass(frozen=True, slots=True)
class ZenohSettings:
    """`[zenoh]` in halo.toml. What is set here counts before `config`, and that before defaults."""

    enabled: bool = True
    listen: tuple[str, ...] = ()
    """Endpoints to wait at; empty: those of `config`, else tcp/127.0.0.1:7447."""
    connect: tuple[str, ...] = ()
    """Endpoints of routers or peers to call; empty: those of `config`, else none."""
    multicast: bool = False
    """Find peers by multicast; false: as `config` says, else off, because multicast is absent on
    many networks, and it leaves the machine."""
    config: str = ""
    """A Zenoh configuration file (JSON5) to start from, for TLS, access control and the like."""


@dataclass(frozen=True, slots=True)
class ControlSettings:
    """`[control]` in halo.toml: the port that clients talk to."""

    host: str = "127.0.0.1"
    port: Annotated[int, Interval(ge=1, le=65_535)] = 9001
