"""A well-behaved client, in a process of its own: counts frames and the longest gap between two.

    python -m fuzzing.good_client URL

It prints a line when the first frame has come, and its figures when its input is closed.
"""

from __future__ import annotations

import json
import sys
import threading
import time

import halo_client
from halo_protocol import TouchFrame


def main() -> None:
    """Follow the service `good` until standard input ends."""
    ended = threading.Event()
    threading.Thread(target=wait_for_end, args=(ended,), daemon=True).start()
    frames, gap_s, last_s = 0, 0.0, None
    with halo_client.connect(sys.argv[1]) as receiver:
        while not ended.is_set():
            arrived = sum(isinstance(event, TouchFrame) for event in receiver.poll(0.1))
            now_s = time.monotonic()
            if last_s is None and arrived:
                print("receiving", flush=True)
            gap_s = max(gap_s, now_s - last_s) if last_s is not None else 0.0
            if arrived:
                frames, last_s = frames + arrived, now_s
    print(json.dumps({"frames": frames, "gap_s": gap_s}))


def wait_for_end(ended: threading.Event) -> None:
    """Set when standard input is closed."""
    sys.stdin.read()
    ended.set()


if __name__ == "__main__":
    main()
