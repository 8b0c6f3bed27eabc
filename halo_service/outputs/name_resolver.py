"""Looks up the names of destinations in a thread of its own, again and again.

Rule: a name may be unknown at the start, get an address later, and change it while the service
runs. The thread only sets `UdpSender.addresses`; it never touches a socket.
"""

from __future__ import annotations

import logging
import threading
import time

from halo_service.outputs.udp_sender import UdpSender, literal_addresses, look_up

log = logging.getLogger(__name__)

AGAIN_S = 30.0
"""How often a known name is looked up."""
RETRY_S = 2.0
"""How often an unknown name, or one that failed, is looked up."""


class NameResolver:
    """For senders to a host name."""

    def __init__(
        self, senders: list[UdpSender], retry_s: float = RETRY_S, again_s: float = AGAIN_S
    ) -> None:
        self._senders = [each for each in senders if not literal_addresses(each.destination.host)]
        self._retry_s, self._again_s = retry_s, again_s
        self._unknown: set[str] = set()
        self._ended = threading.Event()
        if self._senders:
            # Not joined at the end: a lookup may take many seconds, and nothing waits for it.
            threading.Thread(target=self._run, name="names", daemon=True).start()

    def close(self) -> None:
        """End the thread after its present lookup."""
        self._ended.set()

    def _run(self) -> None:
        due_s = dict.fromkeys(range(len(self._senders)), 0.0)
        while not self._ended.is_set():
            now_s = time.monotonic()
            for n, sender in enumerate(self._senders):
                if now_s >= due_s[n] or sender.failed:
                    sender.failed = False
                    self._look_up(sender)
                    due_s[n] = now_s + (self._again_s if sender.addresses else self._retry_s)
            self._ended.wait(self._retry_s)

    def _look_up(self, sender: UdpSender) -> None:
        host = sender.destination.host
        try:
            addresses = look_up(host)
        except (OSError, UnicodeError) as error:
            if host not in self._unknown and not sender.addresses:
                self._unknown.add(host)
                log.warning(
                    "osc: the host '%s' has no address yet (%s); it is looked up again every "
                    "%.0f s; check its name in --osc or [osc] destinations",
                    host,
                    error,
                    self._retry_s,
                )
            return
        if addresses != sender.addresses:
            log.info("osc: %s is %s", host, addresses[0][1])
            sender.addresses = addresses
        self._unknown.discard(host)
