"""The outputs on the page: who gets what, and the test pattern."""

from __future__ import annotations

import secrets
import threading
import time
from collections.abc import Sequence
from typing import Any

import halo_protocol as wire
from halo_service.app.page.observer import PageObserver
from halo_service.app.test_pattern.send import RATE_HZ, PatternSender
from halo_service.errors import UserError
from halo_service.host_clock import CLOCK
from halo_service.outputs.destination import Destination, parse_destination
from halo_service.outputs.frame_encoder import FrameEncoder
from halo_service.outputs.osc import OscOutput
from halo_service.outputs.test_pattern import Pattern
from halo_service.settings import Settings
from halo_service.web.control_page.calls import Call
from halo_service.web.server import WebServer

MOST_PATTERNS = 4
LONGEST_S = 600.0
"""A pattern to one destination ends after this time: a page may be closed before it is stopped."""


class OutputCalls:
    """Tells what is sent, and sends test patterns."""

    def __init__(
        self,
        settings: Settings,
        osc: OscOutput,
        web: WebServer | None,
        zenoh: Sequence[str],
        observer: PageObserver,
    ) -> None:
        """`zenoh`: its endpoints; empty where it is off."""
        self._settings, self._osc, self._web = settings, osc, web
        self._zenoh = zenoh
        self._observer = observer
        self._patterns: dict[str, _PatternThread] = {}

    def table(self) -> dict[str, Call]:
        """Return the calls."""
        return {
            "outputs": Call(self._read, reads=True),
            "start-pattern": Call(self._start),
            "stop-pattern": Call(self._stop),
        }

    def counts(self) -> dict[str, Any]:
        """Return how many clients there are."""
        return {
            "osc_clients": len(self._osc.senders),
            "web_clients": self._web.client_count if self._web else 0,
        }

    def close(self) -> None:
        """End all patterns."""
        for pattern in self._patterns.values():
            pattern.close()

    def _read(self, request: dict[str, Any]) -> dict[str, Any]:
        del request
        return {
            "osc": [
                {
                    "to": str(sender.destination),
                    "rate_hz": sender.destination.stream.rate_hz,
                    "reached": bool(sender.addresses),
                    "datagrams": sender.datagrams,
                    "bytes": sender.bytes,
                }
                for sender in self._osc.senders
            ],
            "websocket": {
                "url": self._web.url if self._web else "",
                "clients": [
                    {
                        "to": f"{each.address} ({'OSC' if each.binary else 'JSON'})",
                        "datagrams": each.messages,
                        "bytes": each.bytes,
                        "dropped": each.dropped,
                    }
                    for each in (self._web.clients if self._web else ())
                ],
            },
            "zenoh": list(self._zenoh),
            "node": self._settings.node,
            "pattern": self._observer.shows_pattern,
            "patterns": [to for to, each in self._patterns.items() if each.runs],
        }

    def _start(self, request: dict[str, Any]) -> dict[str, Any]:
        """Start the pattern on all outputs, or to one destination."""
        to = request["to"]
        if to == "":
            self._observer.start_pattern()
            return {}
        if not isinstance(to, str) or len(to) > 200:
            raise UserError("write host:port, such as 127.0.0.1:4256")
        destination = parse_destination(to)
        self._patterns = {name: each for name, each in self._patterns.items() if each.runs}
        if len(self._patterns) >= MOST_PATTERNS and to not in self._patterns:
            raise UserError(f"at most {MOST_PATTERNS} test patterns can run; stop one")
        if to not in self._patterns:
            self._patterns[to] = _PatternThread(self._settings, destination)
        return {}

    def _stop(self, request: dict[str, Any]) -> dict[str, Any]:
        to = request["to"]
        if to == "":
            self._observer.stop_pattern()
        elif to in self._patterns:
            self._patterns.pop(to).close()
        return {}


class _PatternThread:
    """Sends the pattern to one destination."""

    def __init__(self, settings: Settings, destination: Destination) -> None:
        # A name of its own: a client must not take it for the service.
        node, session = f"{settings.node[:27]}-test", f"s{secrets.token_hex(4)}"
        first = wire.first_frame(CLOCK.unix_us())
        frames = FrameEncoder(node, session, first, settings.osc.max_bytes)
        self._osc = OscOutput([destination])
        self._sender = PatternSender(Pattern(), frames, [self._osc])
        self._ended = threading.Event()
        self._thread = threading.Thread(target=self._run, name="pattern", daemon=True)
        self._thread.start()

    @property
    def runs(self) -> bool:
        return self._thread.is_alive()

    def close(self) -> None:
        self._ended.set()
        self._thread.join()

    def _run(self) -> None:
        until_s = time.monotonic() + LONGEST_S
        while not self._ended.wait(1.0 / RATE_HZ) and time.monotonic() < until_s:
            self._sender.send(time.monotonic())
        self._sender.end()
        self._osc.close()
