"""Faults around the service: neither camera nor tracker is involved."""

from __future__ import annotations

import signal
import time
from collections.abc import Callable

from halo_protocol import Health
from halo_service.profile.store import amend
from tests.faults import profile

from .client import Seen
from .faults import bad
from .figures import UNREPORTED
from .observer import REPORTED_S, Observer

SUSPENDED_S = 4.0
CLIENTS = 20


def without_a_router(observer: Observer) -> None:
    """Kill the Zenoh router, start it again, and wait for a touch that comes through it."""
    running, before, began_s = observer.running, observer.seen.health, time.monotonic()
    running.kill_router()
    reported_s = observer.reported(before, began_s, _unrouted)
    running.start_router()
    running.watch(20.0, running.routes)
    ended_s, routed = time.monotonic(), Seen()
    with running.client_of_the_router() as client:
        while not routed.downs and time.monotonic() - ended_s < REPORTED_S:
            for event in client.poll(0.02):
                routed.update(event, time.monotonic())
            running.watch(0.0)
    back_s = routed.down_s - ended_s if routed.downs else None
    observer.note("router killed", reported_s, back_s)


def suspended(observer: Observer) -> None:
    """Stop the service's process for a while."""
    running, before = observer.running, observer.seen.health
    running.send_signal(signal.SIGSTOP)
    running.watch(0.1)  # what was sent before
    observer.seen.last_frame_s = None  # no frame is sent, so that is no gap
    running.watch(SUSPENDED_S)
    began_s = time.monotonic()
    running.send_signal(signal.SIGCONT)
    back_s = observer.recovery()
    observer.note("suspended", observer.reported(before, began_s, bad), back_s)


def disk_full(observer: Observer) -> None:
    """Let the service save a new background, which needs an empty table, on a full disk."""
    running = observer.running
    running.order("begin", "hands away")
    running.watch(0.5)
    before, began_s = observer.seen.health, time.monotonic()
    running.order("begin", "disk full")
    running.control("/halo/1/control/background")
    reported_s = observer.reported(before, began_s, _unwritten)
    running.order("end", "disk full")
    running.order("end", "hands away")
    observer.note("disk full", reported_s, observer.recovery())


def replaced(observer: Observer) -> None:
    """Replace the profile while the service runs."""
    folder = observer.running.folder / "profile"
    revision = amend(folder, lambda known: known or profile()).revision
    began_s = time.monotonic()

    def used() -> bool:
        return observer.seen.scene is not None and observer.seen.scene.revision == revision

    observer.running.watch(5.0, used)
    observer.note(
        "profile replaced", time.monotonic() - began_s if used() else None, observer.recovery()
    )


def many_clients(observer: Observer) -> None:
    """Let clients come and go."""
    for _ in range(CLIENTS):
        with observer.running.client_that_asks() as client:
            client.poll(0.05)
            observer.running.watch(0.05)
    observer.note(f"{CLIENTS} clients", UNREPORTED, observer.recovery())


FAULTS_AROUND: tuple[Callable[[Observer], None], ...] = (
    without_a_router, suspended, disk_full, replaced, many_clients,
)  # fmt: skip
"""In each round, in this order."""


def kill(observer: Observer) -> None:
    """Kill the service in mid-touch, and start it again."""
    running, seen = observer.running, observer.seen
    running.watch(5.0, lambda: bool(seen.open))
    running.kill()
    running.watch(0.3)  # what was sent before
    sessions, seen.last_frame_s = len(seen.sessions), None
    running.start()
    observer.figures.restarts += 1
    began_s = time.monotonic()
    running.watch(60.0, lambda: len(seen.sessions) > sessions)
    print(f"started again in {time.monotonic() - began_s:.1f} s")
    observer.note("kill -9", UNREPORTED, observer.recovery())


def _unrouted(before: Health, after: Health) -> bool:
    return after.zenoh_missing > 0


def _unwritten(before: Health, after: Health) -> bool:
    return after.write_errors > before.write_errors
