"""Settings of the outputs."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

from annotated_types import Interval

from halo_protocol import DEFAULT_CONTROL_PORT, DEFAULT_PORT, MAX_BUNDLE


@dataclass(frozen=True, slots=True)
class OscSettings:
    """`[osc]` in halo.toml."""

    enabled: bool = True
    """Send frames by UDP to `destinations`."""
    destinations: tuple[str, ...] = (f"127.0.0.1:{DEFAULT_PORT}",)
    """Programs that receive frames by UDP, each as `HOST:PORT[/FORMAT][,OPTION=VALUE ...]`, such as
    `192.168.1.20:4256/flat`. Formats: `frames`, `flat`, `tuio11`, `tuio2`. Options: `rate` (frames
    per second), `surface`, `bundles`, `changes`, `timetags` (on or off), `ttl`, `interface` (for
    multicast)."""
    max_bytes: Annotated[int, Interval(ge=768, le=65_507)] = MAX_BUNDLE
    """Largest datagram, bytes: 1232 passes every VPN, 1432 a wired network without tunnels."""
    again_ms: Annotated[int, Interval(ge=0, le=2000)] = 400
    """When a touch or release is sent once more after its three frames; 0: never. 400 survives a
    Wi-Fi that pauses for 0.3 s, 600 one that pauses for 0.5 s."""


@dataclass(frozen=True, slots=True)
class TuioSettings:
    """`[tuio]` in halo.toml."""

    destinations: tuple[str, ...] = ()
    """Programs that receive TUIO by UDP, such as `127.0.0.1`; written as in `[osc]`, with port 3333
    and format `tuio11` if none is named."""


LISTEN = ("tcp/127.0.0.1:7447",)
"""Default endpoint of the Zenoh peer: Zenoh's usual port, loopback only."""


@dataclass(frozen=True, slots=True)
class ZenohSettings:
    """`[zenoh]` in halo.toml. These settings override `config`; `config` overrides the defaults."""

    enabled: bool = True
    """Send frames by Zenoh."""
    listen: tuple[str, ...] = ()
    """Endpoints to listen on; empty: those of `config`, else tcp/127.0.0.1:7447, or where this port
    is in use the next free one."""
    connect: tuple[str, ...] = ()
    """Endpoints of routers or peers to connect to; empty: those of `config`, else none."""
    multicast: bool = False
    """Find peers by multicast; false: as in `config`, else off. Many networks block multicast, and
    it leaves the machine."""
    config: str = ""
    """A Zenoh configuration file (JSON5) to start from, for TLS, access control and the like."""


@dataclass(frozen=True, slots=True)
class ControlSettings:
    """`[control]` in halo.toml: the port that receives messages from clients."""

    host: str = "127.0.0.1"
    """Address to listen on; 0.0.0.0 lets other machines send commands."""
    port: Annotated[int, Interval(ge=1, le=65_535)] = DEFAULT_CONTROL_PORT
    """UDP port; a free one is used where it is in use."""
    networks: tuple[str, ...] = ("127.0.0.0/8", "::1/128")
    """Only hosts in these networks may send commands or request the stream."""
