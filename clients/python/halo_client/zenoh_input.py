"""Datagrams from Zenoh.

Rule: Zenoh's callback only puts samples into a bounded ring, so that it never blocks; what a
busy client does not fetch is lost from the old end, and heals with the next frame.
"""

from __future__ import annotations

import json
import threading
from collections import deque
from typing import Any, Self

import zenoh

from halo_client.errors import ClientError
from halo_client.source import ZenohSource
from halo_protocol import ANY, zenoh_key

_OWN = zenoh_key(ANY, ANY, ANY).split("/")[:2]
_OTHERS = "halo/*/*/*/scene"
"""Scenes of any major version: a service that speaks another one shall not be plain silence."""

RING = 256
"""Samples that wait at most: some seconds of one service's."""


class ZenohInput:
    """A Zenoh session that subscribes. A context manager; `ClientError` where it cannot open."""

    def __init__(self, source: ZenohSource) -> None:
        self._ring: deque[tuple[bytes, str]] = deque(maxlen=RING)
        self._arrived = threading.Condition()
        self._closed = False
        try:
            self._session = zenoh.open(zenoh_config(source))
        except zenoh.ZError as error:
            raise ClientError(_cannot_open(source, error)) from error
        key = zenoh_key(source.node, source.surface, ANY)
        self._subscriber = self._session.declare_subscriber(key, self._keep)
        self._foreign = self._session.declare_subscriber(_OTHERS, self._keep_foreign)
        self.url = f"zenoh://?{'&'.join(f'connect={endpoint}' for endpoint in source.connect)}"

    def receive(self, timeout_s: float) -> tuple[bytes, str] | None:
        """The next payload and its key, or None where none came for so long."""
        with self._arrived:
            if not self._ring:
                self._arrived.wait(timeout_s)
            return self._ring.popleft() if self._ring else None

    def close(self) -> None:
        """Undeclare, then close: an open subscriber can hold a closing session. Twice is fine."""
        if not self._closed:
            self._closed = True
            self._subscriber.undeclare()
            self._foreign.undeclare()
            self._session.close()

    def _keep(self, sample: zenoh.Sample) -> None:
        with self._arrived:
            self._ring.append((sample.payload.to_bytes(), str(sample.key_expr)))
            self._arrived.notify()

    def _keep_foreign(self, sample: zenoh.Sample) -> None:
        if str(sample.key_expr).split("/")[:2] != _OWN:
            self._keep(sample)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


def zenoh_config(source: ZenohSource) -> zenoh.Config:
    """Zenoh's own configuration for a source."""
    settings: dict[str, Any] = {
        "mode": source.mode,
        "connect/endpoints": list(source.connect),
        "listen/endpoints": list(source.listen),
        "scouting/multicast/enabled": source.multicast,
        # Otherwise peers tell each other of peers, and we would reach whom nobody named.
        "scouting/gossip/enabled": source.multicast,
        # A service that is started later, or anew, is found within a second.
        "connect/retry": {"period_init_ms": 250, "period_max_ms": 1000},
    }
    config = zenoh.Config()
    for key, value in settings.items():
        config.insert_json5(key, json.dumps(value))
    return config


def _cannot_open(source: ZenohSource, error: Exception) -> str:
    named = ", ".join((*source.connect, *source.listen)) or "multicast"
    # Zenoh's sentence ends with the place in its own source, which helps nobody here.
    reason = str(error).partition(" at /")[0].strip()
    return f"cannot open Zenoh with {named} ({reason}); is the service running with Zenoh on?"
