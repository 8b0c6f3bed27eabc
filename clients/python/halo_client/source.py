"""Source URLs.

Rule: text in, frozen values out; nothing is opened here. Each error lists the valid choices.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from urllib.parse import SplitResult, parse_qs, urlsplit

from halo_client.errors import ClientError
from halo_client.follow import FIRST, Follow
from halo_protocol import (
    ANY,
    DEFAULT_CONTROL_PORT,
    DEFAULT_PORT,
    ProtocolError,
    check_name,
    check_surface,
)

DEFAULT_SOURCE = f"osc://127.0.0.1:{DEFAULT_PORT}"
DEFAULT_ZENOH_ENDPOINT = "tcp/127.0.0.1:7447"
FOLLOW_SETTINGS = ("node", "surface", "follow")
RECORDED = ".jsonl"
"""File name suffix of a recorded stream."""
DEFAULT_WEB_PORT = 4258
WEB_PATH = "/halo"
_EXAMPLES = (
    f"{DEFAULT_SOURCE}, ws://127.0.0.1:{DEFAULT_WEB_PORT}{WEB_PATH} or "
    f"zenoh://?connect={DEFAULT_ZENOH_ENDPOINT}"
)


@dataclass(frozen=True, slots=True)
class OscSource:
    """OSC datagrams on a UDP port of this machine."""

    host: str
    """Address to listen on; 0.0.0.0 receives from the whole network."""
    port: int
    """0: a free port, chosen by the system."""
    follow: Follow = FIRST
    """Which service to follow."""
    hello: tuple[str, int] | None = None
    """Control port of the service to request a stream from; None: it sends by its settings."""
    stream: str = "frames"
    """The stream to request, such as `frames,rate=30`."""


@dataclass(frozen=True, slots=True)
class WebSource:
    """The WebSocket of a service."""

    url: str
    """Without the settings, such as `ws://127.0.0.1:4258/halo`."""
    follow: Follow = FIRST
    """Which service to follow."""


@dataclass(frozen=True, slots=True)
class ZenohSource:
    """Zenoh samples from named peers or routers, or from peers found by multicast."""

    connect: tuple[str, ...]
    """Endpoints such as `tcp/127.0.0.1:7447`; an absent peer is tried again."""
    listen: tuple[str, ...] = ()
    """Endpoints on which other peers may reach this one; none by default."""
    multicast: bool = False
    """Whether to find peers by multicast, which many networks block."""
    mode: str = ""
    """`peer` or `client`; empty: as in `config`, else `client` with one endpoint to connect to and
    nothing else, as a router passes nothing from one peer to another."""
    config: str = ""
    """A Zenoh configuration file (JSON5) to start from, for TLS, access control and the like."""
    follow: Follow = FIRST
    """Which service to follow."""


@dataclass(frozen=True, slots=True)
class FileSource:
    """A recorded stream, written by `halo replay --jsonl` or `halo-monitor --json`."""

    path: Path
    paced: bool = True
    """Whether frames come at their recorded times, or as fast as they are read."""


Source = OscSource | WebSource | ZenohSource | FileSource


def parse_source(url: str) -> Source:
    """Read `osc://HOST:PORT`, `ws://HOST:PORT`, `zenoh://?...` or `FILE.jsonl`; else `ClientError`.

    All but files: `?node=...&surface=...` names the service to follow, else the first one is
    followed; `follow=all` reports every service. OSC: `hello=HOST:PORT` asks a service to send
    here, to a free port if the URL names none, and `rate=30` limits its frames per second. Zenoh:
    `connect` and `listen` (any number of each), `multicast=on|off`, `mode=auto|peer|client` and
    `config=FILE`; without `connect`, and multicast off, the source is the service on this machine,
    or what the file names.
    """
    if url.endswith(RECORDED) and "://" not in url:
        return FileSource(Path(url))
    try:
        parts = urlsplit(url)
        port = parts.port
    except ValueError as error:
        raise ClientError(f"cannot read the source {url!r} ({error}); use {_EXAMPLES}") from error
    if parts.scheme == "osc":
        return _osc(url, parts, port)
    if parts.scheme in ("ws", "wss"):
        return _web(url, parts)
    if parts.scheme == "zenoh":
        return _zenoh(url, parts)
    raise ClientError(f"unknown source {url!r}; use {_EXAMPLES}, or a file FILE{RECORDED}")


def _osc(url: str, parts: SplitResult, port: int | None) -> OscSource:
    if parts.path not in ("", "/"):
        raise ClientError(f"osc needs a host and a port, not {url!r}; use {DEFAULT_SOURCE}")
    settings = _settings("osc", parts, ("hello", "rate"))
    hello = _place(settings["hello"][-1]) if "hello" in settings else None
    if "rate" in settings and hello is None:
        raise ClientError("osc: rate needs hello=HOST:PORT, the service to request the stream from")
    default = DEFAULT_PORT if hello is None else 0
    return OscSource(
        parts.hostname or ("127.0.0.1" if hello is None else ""),
        default if port is None else port,
        _follow("osc", settings),
        hello,
        f"frames,rate={settings['rate'][-1]}" if "rate" in settings else "frames",
    )


def _place(text: str) -> tuple[str, int]:
    """Host and control port of a service."""
    try:
        parts = urlsplit(f"//{text}")
        port = DEFAULT_CONTROL_PORT if parts.port is None else parts.port
    except ValueError as error:
        raise ClientError(f"osc: cannot read hello={text!r} ({error})") from error
    if not parts.hostname or not port or parts.path:
        raise ClientError(
            f"osc: hello is the control port of a service, such as "
            f"127.0.0.1:{DEFAULT_CONTROL_PORT}, not {text!r}"
        )
    return parts.hostname, port


def _web(url: str, parts: SplitResult) -> WebSource:
    if not parts.hostname or parts.path not in ("", "/", WEB_PATH):
        raise ClientError(
            f"{parts.scheme} needs a host, a port and {WEB_PATH}, not {url!r}; "
            f"use ws://127.0.0.1:{DEFAULT_WEB_PORT}{WEB_PATH}"
        )
    host = f"[{parts.hostname}]" if ":" in parts.hostname else parts.hostname
    place = f"{parts.scheme}://{host}:{parts.port or DEFAULT_WEB_PORT}{WEB_PATH}"
    return WebSource(place, _follow("ws", _settings("ws", parts, FOLLOW_SETTINGS)))


def _zenoh(url: str, parts: SplitResult) -> ZenohSource:
    if parts.netloc or parts.path not in ("", "/"):
        raise ClientError(f"zenoh accepts settings only, not {url!r}; use {_EXAMPLES}")
    settings = _settings("zenoh", parts, ("connect", "listen", "multicast", "mode", "config"))
    multicast = _one_of("zenoh", settings, "multicast", ("off", "on")) == "on"
    listen = tuple(settings.get("listen", ()))
    config = settings.get("config", [""])[-1]
    mode = _one_of("zenoh", settings, "mode", ("auto", "peer", "client"))
    only_local = not multicast and not listen and not config
    default = (DEFAULT_ZENOH_ENDPOINT,) if only_local else ()
    return ZenohSource(
        connect=tuple(settings.get("connect", default)),
        listen=listen,
        multicast=multicast,
        mode="" if mode == "auto" else mode,
        config=config,
        follow=_follow("zenoh", settings),
    )


def _settings(scheme: str, parts: SplitResult, known: tuple[str, ...]) -> dict[str, list[str]]:
    settings = parse_qs(parts.query, keep_blank_values=True)
    known = tuple(dict.fromkeys((*known, *FOLLOW_SETTINGS)))
    for name in settings:
        if name not in known:
            raise ClientError(
                f"{scheme}: unknown setting {name!r}; choose from: {', '.join(known)}"
            )
    return settings


def _follow(scheme: str, settings: dict[str, list[str]]) -> Follow:
    everything = _one_of(scheme, settings, "follow", ("first", "all")) == "all"
    try:
        node = check_name(settings["node"][-1], "node") if "node" in settings else ANY
        surface = check_surface(settings["surface"][-1]) if "surface" in settings else ANY
    except ProtocolError as error:
        raise ClientError(f"{scheme}: {error}") from error
    return Follow(node, surface, everything)


def _one_of(scheme: str, settings: dict[str, list[str]], name: str, known: tuple[str, ...]) -> str:
    """The value of a setting; default: the first known one."""
    word = settings.get(name, [known[0]])[-1]
    if word not in known:
        choices = f"{', '.join(known[:-1])} or {known[-1]}"
        raise ClientError(f"{scheme}: {name} is {choices}, not {word!r}")
    return word
