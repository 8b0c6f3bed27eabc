"""The same bytes as Zenoh samples, from a peer inside the service.

Keys: `halo/1/{node}/{surface}/{kind}`; a liveliness token announces the node; queries for
scene, homography and pose get the latest one.
"""

from __future__ import annotations

import time
from collections.abc import Sequence

import zenoh

import halo_protocol as wire
from halo_protocol.names import ZENOH_KINDS
from halo_service.outputs.name_watch import NameWatch
from halo_service.outputs.outgoing import Outgoing
from halo_service.outputs.settings import ZenohSettings
from halo_service.outputs.zenoh_port import open_service

RETAINED = ("scene", "homography", "pose")


class ZenohOutput:
    """An embedded Zenoh peer that publishes one node."""

    def __init__(
        self,
        settings: ZenohSettings,
        node: str,
        surface: str,
        names: NameWatch | None = None,
        copies: Sequence[str] = (),
    ) -> None:
        """Open the peer; `names` gets the scenes that others publish under this node's name.

        `copies`: names of further surfaces. Raises `UserError` when it cannot listen or connect.
        """
        self._session, self._connections, used = open_service(settings)
        self.listen = used.listen or (used.config,)
        """Its endpoints, or the file that names them."""
        self._last: dict[tuple[str, str], bytes] = {}
        self._publishers = {
            (each, kind): self._publisher(wire.zenoh_key(node, each, kind), kind)
            for each in (surface, *copies)
            for kind in ZENOH_KINDS
        }
        self._queryables = [
            self._answer(wire.zenoh_key(node, each, kind), (each, kind))
            for each in (surface, *copies)
            for kind in RETAINED
        ]
        self._others = None if names is None else self._subscribe_to_others(node, names)
        self._token = self._session.liveliness().declare_token(wire.liveliness_key(node))

    @property
    def missing(self) -> int:
        """Number of the endpoints to connect to without a connection; Zenoh tries them again."""
        return self._connections.missing

    def send(self, outgoing: Outgoing) -> None:
        """Put each datagram as one sample."""
        where = outgoing.surface, outgoing.kind
        if outgoing.kind in RETAINED:
            self._last[where] = outgoing.datagrams[-1]
        for datagram in outgoing.datagrams:
            self._publishers[where].put(datagram)

    def close(self) -> None:
        """Undeclare everything, then close: closing first can hang."""
        self._token.undeclare()
        if self._others is not None:
            self._others.undeclare()
        for queryable in self._queryables:
            queryable.undeclare()
        for publisher in self._publishers.values():
            publisher.undeclare()
        self._session.close()

    def _subscribe_to_others(self, node: str, names: NameWatch) -> zenoh.Subscriber[None]:
        """Receive scenes of this node's name that are not ours."""

        def look(sample: zenoh.Sample) -> None:
            names.datagram(sample.payload.to_bytes(), time.monotonic())

        key = wire.zenoh_key(node, wire.ANY, "scene")
        return self._session.declare_subscriber(key, look, allowed_origin=zenoh.Locality.REMOTE)

    def _publisher(self, key: str, kind: str) -> zenoh.Publisher:
        return self._session.declare_publisher(
            key,
            congestion_control=zenoh.CongestionControl.DROP,
            priority=zenoh.Priority.REAL_TIME if kind == "frame" else zenoh.Priority.DATA,
            express=True,
        )

    def _answer(self, key: str, where: tuple[str, str]) -> zenoh.Queryable[None]:
        def reply(query: zenoh.Query) -> None:
            retained = self._last.get(where)
            if retained is not None:
                query.reply(key, retained)

        return self._session.declare_queryable(key, reply)
