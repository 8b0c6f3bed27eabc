"""The same bytes as Zenoh samples, from a peer inside the service.

Keys: `halo/1/{node}/{surface}/{kind}`; a liveliness token says that the node is there; what is
retained (scene, homography, pose) also answers queries.
"""

from __future__ import annotations

import json
import re
from typing import Any

import zenoh

import halo_protocol as wire
from halo_protocol.names import ZENOH_KINDS
from halo_service.errors import UserError
from halo_service.files import from_home
from halo_service.outputs.settings import LISTEN, ZenohSettings

RETAINED = ("scene", "homography", "pose")


class ZenohOutput:
    """An embedded Zenoh peer that publishes one surface of one node."""

    def __init__(self, settings: ZenohSettings, node: str, surface: str) -> None:
        """Open the peer. Raises `UserError` when it cannot listen or connect."""
        self._session = _open(settings)
        self._last: dict[str, bytes] = {}
        self._publishers: dict[str, zenoh.Publisher] = {}
        for kind in ZENOH_KINDS:
            key = wire.zenoh_key(node, surface, kind)
            self._publishers[kind] = self._session.declare_publisher(
                key,
                congestion_control=zenoh.CongestionControl.DROP,
                priority=zenoh.Priority.REAL_TIME if kind == "frame" else zenoh.Priority.DATA,
                express=True,
            )
        self._queryables = [self._answer(wire.zenoh_key(node, surface, k), k) for k in RETAINED]
        self._token = self._session.liveliness().declare_token(wire.liveliness_key(node))

    def send(self, kind: str, datagrams: list[bytes]) -> None:
        """Put each datagram as one sample."""
        if kind in RETAINED and datagrams:
            self._last[kind] = datagrams[-1]
        for datagram in datagrams:
            self._publishers[kind].put(datagram)

    def close(self) -> None:
        """Undeclare everything, then close: a peer that is closed first can hang."""
        self._token.undeclare()
        for queryable in self._queryables:
            queryable.undeclare()
        for publisher in self._publishers.values():
            publisher.undeclare()
        self._session.close()

    def _answer(self, key: str, kind: str) -> zenoh.Queryable[None]:
        def reply(query: zenoh.Query) -> None:
            retained = self._last.get(kind)
            if retained is not None:
                query.reply(key, retained)

        return self._session.declare_queryable(key, reply)


def _open(settings: ZenohSettings) -> zenoh.Session:
    config = _started_from(settings.config)
    try:
        config.insert_json5("mode", json.dumps("peer"))
        _fill(config, "listen/endpoints", settings.listen, LISTEN)
        _fill(config, "connect/endpoints", settings.connect, ())
        _fill(config, "scouting/multicast/enabled", settings.multicast, False)
        return zenoh.open(config)
    except zenoh.ZError as error:
        listen, connect = (_endpoints(config, key) for key in ("listen", "connect"))
        raise UserError(
            f"zenoh: cannot listen at {', '.join(settings.listen) or listen} or connect to "
            f"{', '.join(settings.connect) or connect} ({_reason(error)}); another service or "
            f"router may have the port: set [zenoh] listen or connect, or start with --no-zenoh"
        ) from error


def _started_from(path: str) -> zenoh.Config:
    """Read the user's Zenoh configuration, or take Zenoh's own where there is none."""
    if not path:
        return zenoh.Config()
    try:
        return zenoh.Config.from_file(from_home(path))
    except zenoh.ZError as error:
        raise UserError(
            f"zenoh: the configuration {path} cannot be read ({_reason(error)}); "
            f"correct [zenoh] config, or leave it out"
        ) from error


def _fill(config: zenoh.Config, key: str, wanted: Any, default: Any) -> None:
    """Set what the user wants, else leave what the file says, else our default.

    Zenoh fills in what a file leaves out, so a file that says what Zenoh does says nothing.
    """
    if wanted or config.get_json(key) == zenoh.Config().get_json(key):
        config.insert_json5(key, json.dumps(wanted or default))


def _endpoints(config: zenoh.Config, key: str) -> str:
    return config.get_json(f"{key}/endpoints").strip("[]").replace('"', "") or "nothing"


def _reason(error: zenoh.ZError) -> str:
    """What went wrong in Zenoh's words, without where in Zenoh's sources it did."""
    words = re.sub(r"\s*\bat \S+\.rs:\d+\.?", "", str(error)).strip()
    inner = re.search(r'msg: "(.*?)", location', words)
    return inner[1] if inner else words.splitlines()[-1].strip(" =")
