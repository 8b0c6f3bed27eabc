"""An evening in short: a whole service, and everything that goes wrong with it.

    uv run python -m benchmarks.soak             an hour
    uv run python -m benchmarks.soak --seconds 120

The camera is drawn (`tests/faults.py`): a finger taps twice a second. One fault after the other is
switched on and off; a client counts what it receives. Exit code 1 if a pointer stays, an error
leaves the live loop, memory grows by more than 2 %, or a fault is not reported or not recovered
from in time. Linux only.
"""

from __future__ import annotations

import argparse
import json
import logging
import math
import multiprocessing
import os
import resource
import signal
import socket
import statistics
import sys
import tempfile
import threading
import time
from collections.abc import Callable
from contextlib import ExitStack, suppress
from dataclasses import dataclass, field
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any

import halo_client
from halo_protocol import Camera, Health, Lost, ProfileFit, Report, Scene, TouchFrame, Tracker
from halo_service.app.process import use_one_thread_each
from tests.faults import FAULTS, Fault, FaultyCamera, FaultyTracker, profile

RECOVERED_S = 1.5
"""Wanted: from the end of a fault to the next touch."""
REPORTED_S = 12.0
"""Longest wait for a report of a fault: a silent camera is lost after 5 s, a profile does not fit
after 3 checks."""
STUCK_S = 1.5
"""A tap lasts 0.2 s; a pointer that touches for longer is stuck."""
GAP_S = 1.1
"""A client gets a frame at least once a second."""
QUIET_S = 3.0
"""Between two faults: touches are counted."""
TAPS_HZ = 2.0
WARM_UP_S = 20.0
FIRST_FAULTS_S = 300.0
"""Memory is compared from then on: each fault takes some the first times that it happens."""
GROWTH = 0.02
"""Of memory, after warm-up."""
LEAKED_MB = 100
SUSPENDED_S = 4.0
CLIENTS = 20
UNREPORTED = -1.0
"""For what `health` does not report, because frames go on."""


def main() -> int:
    """Run faults until the time is over; print what was seen."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seconds", type=float, default=3600.0)
    seconds = parser.parse_args().seconds
    use_one_thread_each()  # as the `halo` command does; the processes that are started inherit it
    with tempfile.TemporaryDirectory() as folder, ExitStack() as stack:
        evening = Evening(Path(folder), stack)
        evening.run(seconds)
        return evening.result()


# ---- the service, in a process of its own


def serve(folder: Path, ports: dict[str, int], pipe: Connection) -> None:
    """Run the real service on the drawn camera; commands come through the pipe."""
    from halo_service.app.logs import set_up_logging
    from halo_service.app.service import serve as service
    from halo_service.outputs.settings import ControlSettings, OscSettings, ZenohSettings
    from halo_service.settings import Settings
    from halo_service.web.settings import WebSettings

    log = (folder / "service.log").open("a")
    os.dup2(log.fileno(), sys.stderr.fileno())
    set_up_logging(logging.INFO)
    signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    service.open_source = lambda *_: (FaultyCamera(), FaultyCamera)  # type: ignore[assignment]
    service.HandDetector = lambda *_, **__: FaultyTracker()  # type: ignore[assignment, misc]
    service.model_for = lambda *_: Path()
    threading.Thread(target=_obey, args=(pipe,), daemon=True).start()
    service.serve(
        Settings(
            node="soak",
            profile=str(folder / "profile"),
            osc=OscSettings(destinations=(f"127.0.0.1:{ports['osc']}",)),
            control=ControlSettings(port=ports["control"]),
            zenoh=ZenohSettings(
                listen=("tcp/127.0.0.1:0",), connect=(f"tcp/127.0.0.1:{ports['router']}",)
            ),
            web=WebSettings(port=ports["web"], announce=False),
        )
    )


def _obey(pipe: Connection) -> None:
    with suppress(EOFError, OSError):
        while True:
            order, fault = pipe.recv()
            if fault == "disk full":
                size = 0 if order == "begin" else resource.RLIM_INFINITY
                hard = resource.getrlimit(resource.RLIMIT_FSIZE)[1]
                resource.setrlimit(resource.RLIMIT_FSIZE, (size, hard))
            elif order == "begin":
                FAULTS.begin(fault)
            else:
                FAULTS.end(fault)
            pipe.send("done")


def route(port: int) -> None:
    """Run a Zenoh router until it is killed."""
    import zenoh

    config = zenoh.Config()
    for key, value in {
        "mode": "router",
        "listen/endpoints": [f"tcp/127.0.0.1:{port}"],
        "scouting/multicast/enabled": False,
    }.items():
        config.insert_json5(key, json.dumps(value))
    with zenoh.open(config):
        signal.pause()


# ---- the client


@dataclass
class Seen:
    """What the client received."""

    frames: int = 0
    gaps: int = 0
    longest_gap_s: float = 0.0
    downs: int = 0
    stuck: set[tuple[str, int]] = field(default_factory=set)
    sessions: set[str] = field(default_factory=set)
    last_frame_s: float | None = None
    down_s: float = 0.0
    """When the last touch began."""
    health: Health | None = None
    scene: Scene | None = None
    open: dict[tuple[str, int, int], float] = field(default_factory=dict)
    """Touches that go on, and since when."""

    def update(self, event: Any, now_s: float) -> None:
        """Count one event."""
        if isinstance(event, Report):
            message = event.message
            self.health = message if isinstance(message, Health) else self.health
            self.scene = message if isinstance(message, Scene) else self.scene
        elif isinstance(event, Lost):
            self.open = {key: at for key, at in self.open.items() if key[0] != event.session}
            self.last_frame_s = None  # the frame before it was made by the client
        elif isinstance(event, TouchFrame):
            self._frame(event, now_s)

    def _frame(self, frame: TouchFrame, now_s: float) -> None:
        if self.last_frame_s is not None:
            gap_s = now_s - self.last_frame_s
            self.longest_gap_s = max(self.longest_gap_s, gap_s)
            self.gaps += gap_s > GAP_S
        self.last_frame_s = now_s
        self.frames += 1
        self.sessions.add(frame.session)
        if frame.downs:
            self.downs += len(frame.downs)
            self.down_s = now_s
        touching = {(frame.session, p.id, p.contacts) for p in frame.pointers if p.touching}
        self.open = {key: self.open.get(key, now_s) for key in touching}
        self.stuck |= {key[:2] for key, at in self.open.items() if now_s - at > STUCK_S}


# ---- the evening


Shows = Callable[[Health, Health], bool]
"""Whether the later health reports the fault that began after the earlier one."""


def _camera(state: Camera) -> Shows:
    return lambda before, after: after.camera == state


def _bad(before: Health, after: Health) -> bool:
    return after.bad_frames > before.bad_frames


def _fit(before: Health, after: Health) -> bool:
    return after.profile_fit == ProfileFit.TILTED


def _dropped(before: Health, after: Health) -> bool:
    return after.drops > before.drops


def _stepped(before: Health, after: Health) -> bool:
    return after.clock_jumps > before.clock_jumps


def _failed(before: Health, after: Health) -> bool:
    return after.tracker == Tracker.FAILED


def _leaks(before: Health, after: Health) -> bool:
    return after.memory_mb > before.memory_mb + LEAKED_MB


def _unrouted(before: Health, after: Health) -> bool:
    return after.zenoh_missing > 0


def _unwritten(before: Health, after: Health) -> bool:
    return after.write_errors > before.write_errors


SWITCHED: dict[Fault, tuple[float, Shows, bool]] = {
    "drops": (2.0, _dropped, True),
    "stalls": (0.0, _camera(Camera.LOST), True),
    "unplugged": (1.0, _camera(Camera.LOST), True),
    "another device": (1.0, _camera(Camera.LOST), True),
    "black": (1.0, _bad, True),
    "no depth": (1.0, _bad, True),
    "time ahead": (1.0, _bad, True),
    "time back": (1.0, _bad, True),
    "tilted": (0.0, _fit, True),
    "tracker dies": (1.0, _failed, True),
    "tracker hangs": (0.0, _failed, True),
    "tracker leaks": (4.0, _leaks, True),
    "clock stepped": (1.0, _stepped, True),
}
"""Least seconds that a fault lasts, how health reports it, and whether touches must come back."""


class Evening:
    """Runs the service, its faults and the client that watches."""

    def __init__(self, folder: Path, stack: ExitStack) -> None:
        from halo_service.profile.store import save

        self._folder = folder
        self._ports = {name: _free_port() for name in ("osc", "control", "router", "web")}
        self._context = multiprocessing.get_context("spawn")
        save(profile(), folder / "profile")
        self._router = self._start_router()
        self._service, self._pipe = self._start_service()
        stack.callback(lambda: self._end(self._service))
        stack.callback(lambda: self._end(self._router))
        url = f"osc://127.0.0.1:{self._ports['osc']}"
        self._receiver = stack.enter_context(halo_client.connect(url, everything=True))
        self.seen = Seen()
        self.restarts = 0
        self.rows: list[tuple[str, float | None, float | None]] = []
        """Fault, seconds until `health` reported it, seconds until touches came back."""
        self.lost = 0
        self.memory_mb = (0.0, 0.0)
        self.handles = (0, 0)
        self.ended_empty = False
        self._began_s = time.monotonic()
        self._used: list[tuple[float, float, int]] = []
        """Seconds since the start, memory in MB, open files; in each pause between two faults."""

    def run(self, seconds: float) -> None:
        """Switch faults until the time is over."""
        self._began_s = time.monotonic()
        self._watch(60.0, lambda: self.seen.downs > 2)
        self._watch(min(WARM_UP_S, seconds / 5))
        rounds = 0
        while not rounds or self._after_s() < seconds:
            for fault, (least_s, shows, _) in SWITCHED.items():
                self._switched(fault, least_s, shows)
                self._quiet()
                if rounds and self._after_s() > seconds:
                    break
            else:
                self._others()
                rounds += 1
                _, megabytes, files = self._used[-1]
                print(
                    f"after {self._after_s():.0f} s: {megabytes:.1f} MB, {files} files", flush=True
                )
        self._compare(min(FIRST_FAULTS_S, seconds / 2))
        self._kill()
        os.kill(self._service.pid or 0, signal.SIGTERM)
        self._watch(15.0, lambda: not self._service.is_alive())
        self._watch(0.5)
        self.ended_empty = not self.seen.open

    def _switched(self, fault: Fault, least_s: float, shows: Shows) -> None:
        before, began_s = self.seen.health, time.monotonic()
        self._order("begin", fault)
        reported_s = self._reported(before, began_s, shows)
        self._watch(least_s - (time.monotonic() - began_s))
        self._order("end", fault)
        self._row(fault, reported_s, self._recovery())

    def _row(self, fault: str, reported_s: float | None, back_s: float | None) -> None:
        """Note what a fault did; print at once where it is not as wanted."""
        self.rows.append((fault, reported_s, back_s))
        if reported_s is None or back_s is None or back_s > RECOVERED_S:
            said = f"reported {_seconds(reported_s)}, touch {_seconds(back_s)}"
            print(f"after {self._after_s():.0f} s: {fault}: {said}", flush=True)

    def _reported(self, before: Health | None, began_s: float, shows: Shows) -> float | None:
        """Wait until `health` shows a fault; return how long that took, None if it never did."""

        def reported() -> bool:
            return before is not None and shows(before, self.seen.health or before)

        self._watch(REPORTED_S, reported)
        return time.monotonic() - began_s if reported() else None

    def _others(self) -> None:
        """Faults around the service: no camera, no tracker is involved."""
        self._without_a_router()
        self._suspended()
        self._disk_full()
        self._replaced()
        for _ in range(CLIENTS):
            with halo_client.connect(f"osc://?hello=127.0.0.1:{self._ports['control']}") as client:
                client.poll(0.05)
                self._watch(0.05)
        self._row(f"{CLIENTS} clients", UNREPORTED, self._recovery())

    def _without_a_router(self) -> None:
        """Kill the Zenoh router, start it again, and wait for a touch that comes through it."""
        before, began_s = self.seen.health, time.monotonic()
        self._end(self._router)
        reported_s = self._reported(before, began_s, _unrouted)
        self._router = self._start_router()
        self._watch(20.0, self._routes)
        ended_s, routed = time.monotonic(), Seen()
        url = f"zenoh://?mode=client&connect=tcp/127.0.0.1:{self._ports['router']}"
        with halo_client.connect(url) as client:
            while not routed.downs and time.monotonic() - ended_s < REPORTED_S:
                for event in client.poll(0.02):
                    routed.update(event, time.monotonic())
                self._watch(0.0)
        back_s = routed.down_s - ended_s if routed.downs else None
        self._row("router killed", reported_s, back_s)

    def _routes(self) -> bool:
        with socket.socket() as probe:
            return probe.connect_ex(("127.0.0.1", self._ports["router"])) == 0

    def _suspended(self) -> None:
        before = self.seen.health
        os.kill(self._service.pid or 0, signal.SIGSTOP)
        self._watch(0.1)  # what was sent before
        self.seen.last_frame_s = None  # no frame is sent, so that is no gap
        self._watch(SUSPENDED_S)
        began_s = time.monotonic()
        os.kill(self._service.pid or 0, signal.SIGCONT)
        back_s = self._recovery()
        self._row("suspended", self._reported(before, began_s, _bad), back_s)

    def _disk_full(self) -> None:
        """Let the service save a new background, which needs an empty table, on a full disk."""
        self._order("begin", "hands away")
        self._watch(0.5)
        before, began_s = self.seen.health, time.monotonic()
        self._order("begin", "disk full")
        self._control("/halo/1/control/background")
        reported_s = self._reported(before, began_s, _unwritten)
        self._order("end", "disk full")
        self._order("end", "hands away")
        self._row("disk full", reported_s, self._recovery())

    def _replaced(self) -> None:
        """Replace the profile while the service runs."""
        from halo_service.profile.store import amend

        revision = amend(self._folder / "profile", lambda known: known or profile()).revision
        began_s = time.monotonic()
        scene = self.seen.scene
        self._watch(5.0, lambda: (self.seen.scene or scene).revision == revision)  # type: ignore[union-attr]
        reported = self.seen.scene is not None and self.seen.scene.revision == revision
        reported_s = time.monotonic() - began_s if reported else None
        self._row("profile replaced", reported_s, self._recovery())

    def _kill(self) -> None:
        """Kill the service in mid-touch, and start it again."""
        self._watch(5.0, lambda: bool(self.seen.open))
        os.kill(self._service.pid or 0, signal.SIGKILL)
        self._service.join()
        self._watch(0.3)  # what was sent before
        sessions, self.seen.last_frame_s = len(self.seen.sessions), None
        self._service, self._pipe = self._start_service()
        self.restarts += 1
        began_s = time.monotonic()
        self._watch(60.0, lambda: len(self.seen.sessions) > sessions)
        print(f"started again in {time.monotonic() - began_s:.1f} s")
        self._row("kill -9", UNREPORTED, self._recovery())

    def _quiet(self) -> None:
        """Count the touches of a while without a fault."""
        before, began_s = self.seen.downs, time.monotonic()
        self._watch(QUIET_S)
        made = int((time.monotonic() - began_s) * TAPS_HZ) - 1  # one may be cut at each end
        self.lost += max(made - (self.seen.downs - before), 0)

        self._used.append((self._after_s(), *self._usage()))

    def _compare(self, warm_s: float) -> None:
        """Compare memory and open files: medians of the first and the last quarter once it is warm.

        Single values differ by a profile or two, which are replaced again and again.
        """
        warm = [each for each in self._used if each[0] > warm_s] or self._used[-1:]
        part = math.ceil(len(warm) / 4)
        ends = (warm[:part], warm[-part:])
        first, last = (statistics.median(each[1] for each in end) for end in ends)
        self.memory_mb = (first, last)
        first, last = (statistics.median(each[2] for each in end) for end in ends)
        self.handles = (round(first), round(last))

    def _after_s(self) -> float:
        return time.monotonic() - self._began_s

    def _recovery(self) -> float | None:
        ended_s = time.monotonic()
        self._watch(10.0, lambda: self.seen.down_s > ended_s)
        return self.seen.down_s - ended_s if self.seen.down_s > ended_s else None

    def _watch(self, seconds: float, until: Callable[[], bool] = lambda: False) -> None:
        """Receive for a while, or until something is seen."""
        end_s = time.monotonic() + seconds
        while True:
            for event in self._receiver.poll(0.02):
                self.seen.update(event, time.monotonic())
            if time.monotonic() >= end_s or until():
                return

    def _order(self, order: str, fault: str) -> None:
        self._pipe.send((order, fault))
        self._watch(5.0, self._pipe.poll)
        self._pipe.recv()

    def _control(self, address: str) -> None:
        from halo_protocol.osc import padded

        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender:
            sender.sendto(padded(address) + padded(","), ("127.0.0.1", self._ports["control"]))

    def _usage(self) -> tuple[float, int]:
        """Return the service's memory in MB and its open files."""
        process = Path("/proc") / str(self._service.pid)
        pages = int((process / "statm").read_text().split()[1])
        return pages * resource.getpagesize() / 1e6, len(list((process / "fd").iterdir()))

    def _start_service(self) -> tuple[Any, Connection]:
        ours, theirs = self._context.Pipe()
        process = self._context.Process(
            target=serve, args=(self._folder, self._ports, theirs), daemon=True
        )
        process.start()
        theirs.close()
        return process, ours

    def _start_router(self) -> Any:
        process = self._context.Process(target=route, args=(self._ports["router"],), daemon=True)
        process.start()
        return process

    def _end(self, process: Any) -> None:
        process.kill()
        process.join()

    def result(self) -> int:
        """Print what was seen; return the exit code."""
        log = (self._folder / "service.log").read_text()
        # The error of the fault "tracker dies" is logged once; the loop goes on.
        errors = log.count("Traceback (most") - log.count("\nRuntimeError: the model is broken")
        growth = self.memory_mb[1] / self.memory_mb[0] - 1.0
        seen = self.seen
        print(f"{'fault':24} {'times':>5} {'reported after':>15} {'touch again after':>18}")
        for name in dict.fromkeys(row[0] for row in self.rows):
            times = [row for row in self.rows if row[0] == name]
            reported, back = (_worst([row[part] for row in times]) for part in (1, 2))
            print(f"{name:24} {len(times):5} {_seconds(reported):>15} {_seconds(back):>18}")
        print(f"frames {seen.frames}, gaps {seen.gaps}, longest gap {seen.longest_gap_s:.2f} s")
        print(f"touches {seen.downs}, lost {self.lost}, pointers stuck {len(seen.stuck)}")
        if errors:
            print(log[log.find("Traceback (most") :])
        print(f"errors that left the live loop {errors}, restarts {self.restarts}")
        print(
            f"memory {self.memory_mb[0]:.1f} -> {self.memory_mb[1]:.1f} MB ({100 * growth:+.1f} %)"
        )
        print(f"open files {self.handles[0]} -> {self.handles[1]}")
        late = [row for row in self.rows if row[1] is None or row[2] is None]
        slow = [row for row in self.rows if row[2] is not None and row[2] > RECOVERED_S]
        good = not (late or slow or seen.stuck or errors or growth > GROWTH)
        print("passed" if good and self.ended_empty else "failed")
        return 0 if good and self.ended_empty else 1


def _worst(values: list[float | None]) -> float | None:
    return None if None in values else max(value for value in values if value is not None)


def _seconds(value: float | None) -> str:
    if value is None:
        return "never"
    return "-" if value == UNREPORTED else f"{value:.2f} s"


def _free_port() -> int:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


if __name__ == "__main__":
    sys.exit(main())
