"""Datagrams from Zenoh.

Rule: Zenoh's callback only appends samples to a bounded ring, so it never blocks.
"""

from __future__ import annotations

import json
import logging
import threading
import time
from collections.abc import Callable
from contextlib import suppress
from typing import Any, Self

import zenoh

from halo_client.errors import ClientError
from halo_client.interfaces import multicast_interface
from halo_client.ring import Ring
from halo_client.source import ZenohSource
from halo_protocol import ANY, liveliness_key, zenoh_key

_OWN = zenoh_key(ANY, ANY, ANY).split("/")[:2]
_LOG = logging.getLogger(__name__)
_RETRY_S = 1.0
"""Time between two tries to open a session."""
_SILENCE_S = 2.0
"""Time without a frame after which a session by UDP is opened again; a service sends one a second
at least."""
_OTHERS = "halo/*/*/*/scene"
"""Scenes of any major version, so that a service of another one is reported."""

_MOST_LEFT = 1024
"""Nodes that are remembered after they left."""


Subscribe = Callable[[zenoh.Session], list[zenoh.Subscriber[None]]]


class ZenohInput:
    """A Zenoh session that subscribes. A context manager; `ClientError` if it cannot open.

    A session of mode `client` opens only while its router or service runs: a thread tries again
    until then, so that `receive` never waits for an address, and this is logged once. By UDP it is
    opened again while no frame arrives, as the packet with our subscription may be lost.
    """

    def __init__(self, source: ZenohSource, subscribe: Subscribe | None = None) -> None:
        """`subscribe`: declares other subscribers in the session instead of those of `source`."""
        self._subscribe = subscribe or self._subscribe_to_source
        self._ring = Ring()
        self.left: frozenset[str] = frozenset()
        """Nodes that had a liveliness token and have none; replaced whole by Zenoh's thread."""
        self._source = source
        self._open: tuple[zenoh.Session, list[zenoh.Subscriber[None]]] | None = None
        self._heard_s = 0.0
        self._closed = threading.Event()
        self._opener: threading.Thread | None = None
        self.url = f"zenoh://?{'&'.join(f'connect={endpoint}' for endpoint in source.connect)}"
        mode = _checked_mode(source)
        try:
            self._open = self._opened()
        except zenoh.ZError as error:
            if mode != "client":
                raise ClientError(_cannot_open(source, error)) from error
            _LOG.warning("%s; trying again until it answers", _cannot_open(source, error))
        self._by_udp = subscribe is None and any(each.startswith("udp/") for each in source.connect)
        if self._open is None or self._by_udp:
            self._opener = threading.Thread(target=self._keep_open, name="halo zenoh", daemon=True)
            self._opener.start()

    def receive(self, timeout_s: float) -> tuple[bytes, str] | None:
        """The next payload and its key, or None after the timeout."""
        return self._ring.get(timeout_s)

    def close(self) -> None:
        """Undeclare, then close: an open subscriber can block a closing session. May be called
        twice."""
        self._closed.set()
        if self._opener is not None:
            self._opener.join()
        self._shut()

    def _shut(self) -> None:
        if self._open is not None:
            (session, subscribers), self._open = self._open, None
            for subscriber in subscribers:
                subscriber.undeclare()
            session.close()

    def _keep_open(self) -> None:
        """Open the session as soon as it can be; by UDP, again while no frame arrives."""
        while not self._closed.wait(_RETRY_S):
            if self._by_udp and time.monotonic() - self._heard_s > _SILENCE_S:
                self._shut()
            if self._open is None:
                with suppress(zenoh.ZError):
                    self._open = self._opened()
            elif not self._by_udp:
                return

    def _opened(self) -> tuple[zenoh.Session, list[zenoh.Subscriber[None]]]:
        """Open a session and subscribe. Raises `ZError`."""
        session = zenoh.open(zenoh_config(self._source))
        self._heard_s = time.monotonic()
        try:
            return session, self._subscribe(session)
        except zenoh.ZError:
            session.close()  # the threads of its subscribers would never end
            raise

    def _subscribe_to_source(self, session: zenoh.Session) -> list[zenoh.Subscriber[None]]:
        follow = self._source.follow
        key = zenoh_key(follow.node, follow.surface, ANY)
        subscribers = [
            session.declare_subscriber(key, self._store),
            session.declare_subscriber(_OTHERS, self._store_foreign),
            session.liveliness().declare_subscriber(
                liveliness_key(follow.node), self._note, history=True
            ),
        ]
        # The latest scene, homography and pose at once; they come twice a second anyway.
        session.get(key, self._store_reply, timeout=_RETRY_S)
        return subscribers

    def _store(self, sample: zenoh.Sample) -> None:
        key = str(sample.key_expr)
        if key.endswith("/frame"):
            self._heard_s = time.monotonic()
        self._ring.put(sample.payload.to_bytes(), key)

    def _store_reply(self, reply: zenoh.Reply) -> None:
        if reply.ok is not None:
            self._store(reply.ok)

    def _store_foreign(self, sample: zenoh.Sample) -> None:
        if str(sample.key_expr).split("/")[:2] != _OWN:
            self._store(sample)

    def _note(self, token: zenoh.Sample) -> None:
        """Note a node that comes or leaves: its process has ended, or its link is dead."""
        node = {str(token.key_expr).split("/")[2]}
        if token.kind == zenoh.SampleKind.PUT:
            self.left -= node
        elif len(self.left) < _MOST_LEFT:
            self.left |= node

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


def zenoh_config(source: ZenohSource) -> zenoh.Config:
    """The Zenoh configuration of a source. `ZError` for a bad endpoint, or a file that cannot be
    read."""
    settings: dict[str, Any] = {
        "connect/endpoints": list(source.connect),
        "listen/endpoints": list(source.listen),
        "scouting/multicast/enabled": source.multicast,
        "scouting/multicast/interface": multicast_interface(),
        # With gossip on, peers would connect us to peers that the user did not name.
        "scouting/gossip/enabled": source.multicast,
        # A service that starts later, or again, is found within a second.
        "connect/retry": {"period_init_ms": 250, "period_max_ms": 1000},
        # A service at 0.0.0.0 names all of its interfaces. Zenoh's own limit is 10 s for each that
        # cannot be reached.
        "transport/unicast/open_timeout": 1000,
        # After so much silence a link is closed and opened again. Zenoh waits 10 s, and TCP up to
        # as long as the link was cut.
        "transport/link/tx/lease": 3000,
    }
    config = zenoh.Config.from_file(source.config) if source.config else zenoh.Config()
    for key, value in settings.items():
        # What the file sets is replaced by a setting of the user, and not by a default.
        if value or config.get_json(key) == zenoh.Config().get_json(key):
            config.insert_json5(key, json.dumps(value))
    if source.mode or not json.loads(config.get_json("mode")):
        config.insert_json5("mode", json.dumps(source.mode or _mode(config)))
    return config


def _mode(config: zenoh.Config) -> str:
    """A client can have one connection only. A peer hears nothing of other peers of its router."""
    connect, listen, multicast = (
        json.loads(config.get_json(key))
        for key in ("connect/endpoints", "listen/endpoints", "scouting/multicast/enabled")
    )
    one = isinstance(connect, list) and len(connect) == 1
    return "client" if one and not listen and not multicast else "peer"


def _checked_mode(source: ZenohSource) -> str:
    """Return the mode of its session; refuse what never opens, however often it is tried."""
    try:
        return str(json.loads(zenoh_config(source).get_json("mode")))
    except zenoh.ZError as error:
        raise ClientError(
            f"cannot use Zenoh with {_named(source)} ({_reason(error)}); write endpoints as "
            "tcp/HOST:PORT, and a configuration as a JSON5 file"
        ) from error


def _cannot_open(source: ZenohSource, error: Exception) -> str:
    return (
        f"cannot open Zenoh with {_named(source)} ({_reason(error)}); check that the service or "
        "router runs there"
    )


def _named(source: ZenohSource) -> str:
    return ", ".join((*source.connect, *source.listen)) or source.config or "multicast"


def _reason(error: Exception) -> str:
    """Cut off the names of Zenoh's types before its message, and the place in its code after it."""
    reason = str(error).partition(" at /")[0].rpartition('msg: "')[2].strip()
    return "no answer" if reason.startswith("Unable to connect") else reason
