"""Opens a Zenoh session: the user's settings, over a configuration file, over our defaults."""

from __future__ import annotations

import json
import logging
import re
from collections.abc import Sequence
from typing import Any

import zenoh

from halo_client.interfaces import multicast_interface
from halo_service.errors import UserError
from halo_service.files import from_home
from halo_service.outputs.settings import LISTEN, ZenohSettings

log = logging.getLogger(__name__)

RETRY = {"period_init_ms": 250, "period_max_ms": 500}
LEASE_MS = 3000


class Connections:
    """The connections that a session shall have. Zenoh tries absent ones again."""

    def __init__(self, session: zenoh.Session, endpoints: Sequence[str]) -> None:
        self._session = session
        self.endpoints = tuple(endpoints)
        self._away: list[str] = []

    @property
    def missing(self) -> int:
        """Number of endpoints without a connection; each change is logged."""
        linked = {_protocol_and_port(link.dst) for link in self._session.info.links()}
        away = [each for each in self.endpoints if _protocol_and_port(each) not in linked]
        for each in away if away != self._away else ():
            log.warning("zenoh: no connection to %s; trying again until it answers", each)
        if self._away and not away:
            log.warning("zenoh: connected to %s", ", ".join(self.endpoints))
        self._away = away
        return len(away)


def open_session(
    settings: ZenohSettings,
    mode: str,
    remedy: str = "set [zenoh] listen or connect, or start with --no-zenoh",
    also: Sequence[str] = (),
) -> tuple[zenoh.Session, Connections]:
    """Open a `peer`, a `router` or a `client`; return it and its connections.

    `remedy`: what to do if it cannot listen or connect; `also`: endpoints to connect to that are
    not reported while they are missing. Raises `UserError`.
    """
    config = _base_config(settings.config, mode)
    try:
        _set(config, settings, mode)
        connects = _connects(config)
        if also:
            config.insert_json5("connect/endpoints", json.dumps([*connects, *also]))
        session = zenoh.open(config)
        return session, Connections(session, connects)
    except zenoh.ZError as error:
        raise UserError(_refusal(config, settings, reason(error), remedy)) from error


def _refusal(config: zenoh.Config, settings: ZenohSettings, why: str, remedy: str) -> str:
    """Say what could not be opened, and what to do."""
    listen = ", ".join(settings.listen) or _endpoints(config, "listen")
    connect = ", ".join(settings.connect) or _endpoints(config, "connect")
    tried = [f"listen at {listen}"] if listen else []
    tried += [f"connect to {connect}"] if connect else []
    remedy = f"another service or router may have the port: {remedy}"
    if why.startswith("Endpoints must be"):
        remedy = "write endpoints as tcp/HOST:PORT"
    return f"zenoh: cannot {' or '.join(tried) or 'open'} ({why}); {remedy}"


def reason(error: zenoh.ZError) -> str:
    """Return Zenoh's error text without the position in Zenoh's source code."""
    words = re.sub(r"\s*\bat \S+\.rs:\d+\.?", "", str(error)).strip()
    inner = re.search(r'msg: "(.*?)", location', words)
    return inner[1] if inner else words.splitlines()[-1].strip(" =")


def _set(config: zenoh.Config, settings: ZenohSettings, mode: str) -> None:
    config.insert_json5("mode", json.dumps(mode))
    _fill(config, "listen/endpoints", settings.listen, () if mode == "client" else LISTEN)
    _fill(config, "connect/endpoints", settings.connect, ())
    _fill(config, "scouting/multicast/enabled", settings.multicast, False)
    _fill(config, "scouting/multicast/interface", None, multicast_interface())
    if mode != "router":
        # Else each service hears of all others of its router and connects to them: 4950 links for
        # 100 of them. And it would wait half a second for them at its start.
        _fill(config, "scouting/gossip/enabled", settings.multicast, False)
        _fill(config, "open/return_conditions/connect_scouted", settings.multicast, False)
    # Zenoh's own limit is 10 s for each address of a peer that cannot be reached.
    _fill(config, "transport/unicast/open_timeout", None, 1000)
    # A router that starts later, or again, is found soon.
    _fill(config, "connect/retry", None, RETRY)
    # A dead link is closed and opened again after 3 s. Zenoh waits 10 s, and TCP up to as long as
    # the link was cut.
    _fill(config, "transport/link/tx/lease", None, LEASE_MS)
    # A router reports its version and its connections to whoever may read them.
    _fill(config, "adminspace/enabled", None, mode == "router")


def _base_config(path: str, mode: str) -> zenoh.Config:
    """Read the user's Zenoh configuration; without one, Zenoh's defaults."""
    if not path:
        return zenoh.Config()
    file = from_home(path)
    try:
        return zenoh.Config.from_file(file)
    except zenoh.ZError as error:
        setting = "the file" if mode == "router" else "[zenoh] config"
        why = reason(error) if file.is_file() else "file not found"
        raise UserError(
            f"zenoh: the configuration {path} cannot be read ({why}); "
            f"correct {setting}, or leave it out"
        ) from error


def _fill(config: zenoh.Config, key: str, value: Any, default: Any) -> None:
    """Set the user's value, else keep the value of the file, else set our default.

    Zenoh fills in missing values, so a value equal to Zenoh's default counts as not set.
    """
    if value or config.get_json(key) == zenoh.Config().get_json(key):
        config.insert_json5(key, json.dumps(value or default))


def _connects(config: zenoh.Config) -> list[str]:
    endpoints = json.loads(config.get_json("connect/endpoints"))
    return [each for each in endpoints if isinstance(each, str)] if endpoints else []


def _protocol_and_port(locator: str) -> tuple[str, str]:
    """Return what a link and its endpoint have in common: its host may be a name."""
    address = re.split(r"[?#]", locator)[0]
    return address.partition("/")[0], address.rpartition(":")[2]


def _endpoints(config: zenoh.Config, key: str) -> str:
    return str(config.get_json(f"{key}/endpoints")).strip("[]").replace('"', "")
