"""The same bytes as Zenoh samples, from a peer inside the service.

Keys: `halo/1/{node}/{surface}/{kind}`; a liveliness token says that the node is there; what is
retained (scene, homography, pose) also answers queries.
"""

from __future__ import annotations

import json

import zenoh

import halo_protocol as wire
from halo_protocol.names import ZENOH_KINDS
from halo_service.errors import UserError
from halo_service.outputs.settings import ZenohSettings

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
    try:
        config = zenoh.Config.from_file(settings.config) if settings.config else zenoh.Config()
        config.insert_json5("mode", json.dumps("peer"))
        config.insert_json5("listen/endpoints", json.dumps(list(settings.listen)))
        config.insert_json5("connect/endpoints", json.dumps(list(settings.connect)))
        config.insert_json5("scouting/multicast/enabled", json.dumps(settings.multicast))
        return zenoh.open(config)
    except zenoh.ZError as error:
        reason = str(error).strip().splitlines()[0]
        raise UserError(
            f"zenoh: cannot listen at {', '.join(settings.listen) or 'nothing'} or connect to "
            f"{', '.join(settings.connect) or 'nothing'} ({reason}); another service or router may "
            f"have the port: set [zenoh] listen or connect, or start with --no-zenoh"
        ) from error
