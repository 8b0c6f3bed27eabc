"""Random and mutated datagrams, HTTP requests and WebSocket messages: to service and clients.

    python benchmarks/fuzz.py --count 1000000

The service is the real `halo serve`. While it is attacked in three ways at once, two well-behaved
clients receive its stream, by UDP and by WebSocket. Our client libraries then read the same kinds
of input, with frames of a good service between them. It fails if anything raises, if memory grows,
or if a well-behaved client waits.
"""

from __future__ import annotations

import argparse
import json
import logging
import multiprocessing
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from fuzzing import attacks, clients
from fuzzing.service import Service

HERE = Path(__file__).parent
MOST_GROWTH_MB = 16.0
"""16 bytes for each of a million inputs."""
LONGEST_GAP_S = 3.0
"""Silence after which a client treats the service as lost."""
ATTACKERS_NICE = 10
"""A busy machine slows the attackers down, not the service that they attack."""
SHARES = {"datagrams": 0.6, "messages": 0.3, "requests": 0.1}
"""Of the inputs for the service."""
ERRORS = ("Traceback", "Error handling", "unexpected", "exception", "destroyed")
"""Words in the service's log that a receiver must not cause."""


@dataclass
class Report:
    """Prints figures, and remembers which are not as they must be."""

    failed: int = 0

    def line(self, name: str, text: str, *, good: bool) -> None:
        """Print one."""
        print(f"{'ok  ' if good else 'FAIL'} {name:24} {text}", flush=True)
        self.failed += not good


def main() -> int:
    """Attack; 1 if anything failed."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--count", type=int, default=20_000, help="inputs for the service")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--source", default="", help="of `halo serve`; default: a small recording")
    options = parser.parse_args()
    logging.disable(logging.WARNING)  # the clients' own warnings, one a sender
    report = Report()
    with tempfile.TemporaryDirectory() as folder:
        attack_service(options.count, options.seed, options.source, Path(folder), report)
    attack_clients(options.count, options.seed, report)
    return int(report.failed > 0)


def attack_service(count: int, seed: int, source: str, folder: Path, report: Report) -> None:
    """Attack the service in three ways at once."""
    with Service(folder, "--no-osc", source=source) as service:
        urls = (
            f"osc://?hello=127.0.0.1:{service.control_port}&node=good",
            f"{service.url}?node=good",
        )
        context = multiprocessing.get_context("spawn")
        with (
            good_clients(urls, report),
            context.Pool(3, initializer=os.nice, initargs=(ATTACKERS_NICE,)) as pool,
        ):
            started_s = time.monotonic()
            ports = (service.control_port, service.web_port, service.web_port)
            senders = (attacks.send_datagrams, attacks.send_messages, attacks.send_requests)
            running = [
                (name, number, pool.apply_async(send, (port, seed, number)))
                for (name, number), port, send in zip(shared(count), ports, senders, strict=True)
            ]
            memories = [service.memory_mb()]
            while not all(result.ready() for _, _, result in running) and service.running:
                time.sleep(0.2)
                memories.append(service.memory_mb())
            for name, number, result in running:
                unanswered = result.get(1.0)
                report.line(name, f"{number} sent, {unanswered} unanswered", good=not unanswered)
            seconds = time.monotonic() - started_s
        settled, end = max(memories[: len(memories) // 5 + 1]), memories[-1]
        text = f"{settled:.1f} MB after a fifth, {end:.1f} MB after {seconds:.0f} s"
        report.line("service's memory", text, good=end - settled <= MOST_GROWTH_MB)
        code, log = service.stop(), service.log
        bad = [line for line in log.splitlines() if any(word in line for word in ERRORS)]
        report.line(
            "service", f"exit {code}, {len(log.splitlines())} log lines", good=not (code or bad)
        )
        for line in bad[:10]:
            print("    ", line)


def shared(count: int) -> list[tuple[str, int]]:
    """Return how many of each kind."""
    return [(name, max(1, round(count * share))) for name, share in SHARES.items()]


@contextmanager
def good_clients(urls: tuple[str, ...], report: Report) -> Iterator[None]:
    """Let well-behaved clients receive, and report what they got."""
    command = [sys.executable, "-m", "fuzzing.good_client"]
    pipe = subprocess.PIPE
    running = [
        subprocess.Popen([*command, url], cwd=HERE, stdin=pipe, stdout=pipe, text=True)
        for url in urls
    ]
    for each in running:
        assert each.stdout is not None
        each.stdout.readline()
    started_s = time.monotonic()
    yield
    seconds = time.monotonic() - started_s
    for url, each in zip(urls, running, strict=True):
        said, _ = each.communicate(timeout=30.0)
        found = json.loads(said)
        rate_hz = found["frames"] / seconds
        text = f"{rate_hz:.1f} frames/s, longest gap {found['gap_s'] * 1000:.0f} ms"
        good = found["gap_s"] <= LONGEST_GAP_S and rate_hz > 1.0
        report.line(f"a client by {url[:3].strip(':')}", text, good=good)


def attack_clients(count: int, seed: int, report: Report) -> None:
    """Send to our client libraries; the slower ones get fewer."""
    kinds: dict[str, tuple[Callable[[int, int], clients.Result | None], int]] = {
        "Python client by UDP": (clients.python_by_udp, count),
        "Python client by WS": (clients.python_by_websocket, count // 4),
        "halo.js": (clients.javascript, count // 4),
    }
    for name, (attack, number) in kinds.items():
        result = attack(number, seed)
        if result is None:
            print(f"skip {name:24} node is not installed")
            continue
        early_mb, end_mb = result.memory_mb
        text = (
            f"{result.sent} sent, {result.shown} of {result.good} good frames shown, "
            f"{early_mb:.1f} -> {end_mb:.1f} MB"
        )
        good = result.shown == result.good and end_mb - early_mb <= MOST_GROWTH_MB
        report.line(name, text, good=good)


if __name__ == "__main__":
    sys.exit(main())
