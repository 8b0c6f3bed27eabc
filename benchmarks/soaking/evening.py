"""One fault after the other, until the time is over."""

from __future__ import annotations

import signal
import time

from tests.faults import Fault

from .around import FAULTS_AROUND, kill
from .faults import SWITCHED, Shows
from .observer import Observer

WARM_UP_S = 20.0
FIRST_FAULTS_S = 300.0
"""Memory is compared from then on: each fault takes some the first times that it happens."""


def run(observer: Observer, seconds: float) -> None:
    """Switch faults until the time is over, then end the service."""
    running, seen = observer.running, observer.seen
    running.watch(60.0, lambda: seen.downs > 2)
    running.watch(min(WARM_UP_S, seconds / 5))
    rounds = 0
    while not rounds or observer.after_s() < seconds:
        for fault, (least_s, shows) in SWITCHED.items():
            _switched(observer, fault, least_s, shows)
            observer.quiet()
            if rounds and observer.after_s() > seconds:
                break
        else:
            for happen in FAULTS_AROUND:
                happen(observer)
            rounds += 1
            megabytes, files = running.usage()
            print(
                f"after {observer.after_s():.0f} s: {megabytes:.1f} MB, {files} files", flush=True
            )
    observer.compare(min(FIRST_FAULTS_S, seconds / 2))
    kill(observer)
    running.send_signal(signal.SIGTERM)
    running.watch(15.0, lambda: not running.alive)
    running.watch(0.5)
    observer.figures.ended_empty = not seen.open


def _switched(observer: Observer, fault: Fault, least_s: float, shows: Shows) -> None:
    before, began_s = observer.seen.health, time.monotonic()
    observer.running.order("begin", fault)
    reported_s = observer.reported(before, began_s, shows)
    observer.running.watch(least_s - (time.monotonic() - began_s))
    observer.running.order("end", fault)
    observer.note(fault, reported_s, observer.recovery())
