"""A service without a camera: ten fingers that tap, 25 touches a second, on the outputs of a file.

    python publisher.py halo.toml SECONDS

It prints `ready`, sends frames without fingers until it gets a line, then touches, and prints at
its end the touches that it sent, as a JSON list of [id, contacts].
"""

from __future__ import annotations

import json
import logging
import select
import sys
import time
from collections.abc import Iterator
from contextlib import ExitStack, closing
from dataclasses import replace
from pathlib import Path

import halo_protocol as wire
from halo_service.app.service.carriers import destinations, zenoh_output
from halo_service.host_clock import CLOCK
from halo_service.outputs import Carrier
from halo_service.outputs.frame_encoder import FrameEncoder
from halo_service.outputs.name_watch import NameWatch
from halo_service.outputs.osc import OscOutput
from halo_service.outputs.outgoing import Outgoing, OutgoingReport
from halo_service.outputs.test_pattern import TURN_S, Pattern
from halo_service.settings import Settings, load
from halo_service.values import TouchFrame

RATE_HZ = 30.0
FAST = 10.0
"""Times the test pattern's speed: a finger taps every 0.4 s."""
FINGERS = 10
REPORT_S = 0.5
SESSION = "s1"
HOMOGRAPHY = (2.0, 0.0, 1.0, 0.0, 2.0, 1.0, 0.0, 0.0, 1.0)
POSE = (1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 700.0)


def main() -> None:
    """Publish, and print what was published."""
    settings, seconds = load(Path(sys.argv[1])), float(sys.argv[2])
    logging.basicConfig(format="%(message)s")
    with ExitStack() as stack:
        osc = stack.enter_context(closing(OscOutput(destinations(settings))))
        names = NameWatch(settings.node, SESSION)
        publisher = Publisher(settings, [osc, *zenoh_output(settings, names, "table", stack)])
        print("ready", flush=True)
        while not select.select([sys.stdin], [], [], 0.0)[0]:
            publisher.send(replace(fingers(0.0), pointers=()))
        began_s, before_s = time.monotonic(), -1.0
        while (now_s := time.monotonic() - began_s) < seconds:
            publisher.send(fingers(now_s, before_s))
            before_s = now_s
        for _ in range(round(RATE_HZ)):
            publisher.send(replace(fingers(0.0), pointers=()))
        print(json.dumps(publisher.downs), flush=True)


class Publisher:
    """Sends frames at their rate, and reports twice a second."""

    def __init__(self, settings: Settings, carriers: list[Carrier]) -> None:
        self._node, self._carriers = settings.node, carriers
        first = wire.first_frame(CLOCK.unix_us())
        again_ms = settings.osc.again_ms
        self._encoder = FrameEncoder(self._node, SESSION, first, again_ms=again_ms)
        self._report_s = 0.0
        self.downs: list[list[int]] = []
        """Touches: [id, contacts]."""

    def send(self, frame: TouchFrame) -> None:
        """Send a frame, and wait until the next one is due."""
        self.downs += [[each.id, each.contacts] for each in frame.events if each.kind == "down"]
        self._to_all(self._encoder.encode(frame))
        if time.monotonic() >= self._report_s:
            self._report_s = time.monotonic() + REPORT_S
            for report in reports(self._node):
                self._to_all(OutgoingReport("table", report))
        time.sleep(1.0 / RATE_HZ)

    def _to_all(self, outgoing: Outgoing) -> None:
        for carrier in self._carriers:
            carrier.send(outgoing)


def fingers(now_s: float, before_s: float | None = None) -> TouchFrame:
    """Return the frame of a time; without the time of the frame before, there are no events."""
    parts = []
    for slot in range(FINGERS):
        late_s = slot * TURN_S / FINGERS
        t_s, last_s = (max(each * FAST - late_s, -1.0) for each in (now_s, before_s or now_s))
        part = Pattern(pointer_id=slot + 1).frame(t_s, last_s, CLOCK.unix_us())
        if t_s >= 0.0:
            parts.append((slot, part))
    events = [replace(e, slot=n, ago_ms=e.ago_ms / FAST) for n, part in parts for e in part.events]
    pointers = [replace(p, slot=n) for n, part in parts for p in part.pointers]
    return replace(
        Pattern().frame(0.0, 0.0, CLOCK.unix_us()), pointers=tuple(pointers), events=tuple(events)
    )


def reports(node: str) -> Iterator[wire.Scene | wire.Homography | wire.Pose]:
    """Yield what a service repeats twice a second."""
    size_mm = Pattern().width_mm, Pattern().height_mm
    yield wire.Scene(node, SESSION, wire.VERSION, *size_mm, 2, 1, 2, RATE_HZ)
    yield wire.Homography(node, SESSION, 1, 1280, 800, HOMOGRAPHY)
    yield wire.Pose(node, SESSION, 1, POSE, POSE)


if __name__ == "__main__":
    main()
