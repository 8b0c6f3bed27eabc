"""A client that counts touches, and measures on the clock of this computer how late frames arrive.

    python listener.py URL

It prints `ready` with the first frame, listens until it gets a line, and prints one JSON object;
`known_s` is the time from the start until it has scene, homography and pose.
"""

from __future__ import annotations

import json
import select
import sys
import time
from itertools import pairwise

import halo_client
import halo_protocol as wire


def main() -> None:
    """Listen, and print what arrived."""
    downs: list[list[int]] = []
    ups: list[list[int]] = []
    late_ms: list[float] = []
    at_s: list[float] = []
    lost, known_s = 0, -1.0
    began_s = time.monotonic()
    with halo_client.connect(sys.argv[1]) as receiver:
        receiver.on_down(lambda each: downs.append([each.key.id, each.key.contacts]))
        receiver.on_up(lambda each: ups.append([each.key.id, each.key.contacts]))
        while not select.select([sys.stdin], [], [], 0.0)[0]:
            for event in receiver.poll(0.05):
                if isinstance(event, halo_client.TouchFrame):
                    if not late_ms:
                        print("ready", flush=True)
                    late_ms.append(time.time() * 1000.0 - event.time_us / 1000.0)
                    at_s.append(time.monotonic())
                lost += isinstance(event, wire.Lost)
            known = receiver.services
            if known_s < 0.0 and known.scenes and known.homographies and known.poses:
                known_s = time.monotonic() - began_s
    gaps_s = [b - a for a, b in pairwise(at_s)]
    result = {
        "downs": downs,
        "ups": ups,
        "late_ms": sorted(late_ms),
        "lost": lost,
        "missed": receiver.losses.missed,
        "longest_gap_s": max(gaps_s, default=0.0),
        "known_s": known_s,
    }
    print(json.dumps(result))


if __name__ == "__main__":
    main()
