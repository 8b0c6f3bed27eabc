"""Reports to systemd that the service is ready, alive, and ends (sd_notify).

Rule: without systemd it does nothing. A datagram is sent, nothing waits for an answer.
"""

from __future__ import annotations

import os
import socket
import time
from collections.abc import Callable, Mapping
from contextlib import suppress

BEATS = 3
"""Reports in the time after which systemd restarts a silent service."""


class Notifier:
    """The manager that started this process, if there is one."""

    def __init__(
        self,
        environment: Mapping[str, str] = os.environ,
        now_s: Callable[[], float] = time.monotonic,
    ) -> None:
        """`environment`: systemd sets NOTIFY_SOCKET, WATCHDOG_USEC and WATCHDOG_PID."""
        self._address = environment.get("NOTIFY_SOCKET", "").replace("@", "\0", 1)
        self._now_s = now_s
        limit_us = environment.get("WATCHDOG_USEC", "")
        ours = environment.get("WATCHDOG_PID", str(os.getpid())) == str(os.getpid())
        self._every_s = int(limit_us) / 1e6 / BEATS if limit_us.isdigit() and ours else None
        self._sent_s = float("-inf")

    def ready(self) -> None:
        """Report that the service runs."""
        self._send("READY=1")

    def alive(self) -> None:
        """Report that the live loop goes on; call it as often as you like."""
        now_s = self._now_s()
        if self._every_s is not None and now_s - self._sent_s >= self._every_s:
            self._sent_s = now_s
            self._send("WATCHDOG=1")

    def stopping(self) -> None:
        """Report that the service ends."""
        self._send("STOPPING=1")

    def _send(self, message: str) -> None:
        if not self._address or not hasattr(socket, "AF_UNIX"):
            return
        with suppress(OSError), socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as manager:
            manager.connect(self._address)
            manager.send(message.encode())
