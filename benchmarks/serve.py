"""How soon and how steadily the virtual service speaks: `uv run python benchmarks/serve.py`.

Starts `halo serve` with the virtual camera and listens as a client does. Prints the seconds from
start to the first frame and the first pointer, the frames a second over the time after, and what
the service says of itself. Seconds depend on the machine and on what else it does. The virtual
camera loses one frame in 200, and each is a gap: `serve.py 'sim?drop=0'` shows those of the
service alone. Ends with a sentence if no pointer comes within three minutes;
`benchmarks/beside.py` has the ratio to an older commit.
"""

from __future__ import annotations

import socket
import subprocess
import sys
import time
from itertools import pairwise
from pathlib import Path

import halo_protocol as wire

LISTEN_S = 30.0
START_S = 180.0
GAP_S = 0.05


def main() -> None:
    """Start, listen, print."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as client:
        client.bind(("127.0.0.1", 0))
        client.settimeout(1.0)
        destination = f"127.0.0.1:{client.getsockname()[1]}"
        halo, source = Path(sys.executable).with_name("halo"), (*sys.argv[1:], "sim")[0]
        command = [str(halo), "serve", "--source", source]
        began_s = time.monotonic()
        service = subprocess.Popen(
            [*command, "--osc", destination, "--no-zenoh", "--control-port", "9321"],
            stderr=subprocess.DEVNULL,
        )
        try:
            listen(client, began_s)
        finally:
            service.terminate()
            service.wait()


def listen(client: socket.socket, began_s: float) -> None:
    """Print what arrives."""
    first: dict[type, float] = {}
    arrived: dict[int, float] = {}
    health, until_s = None, began_s + START_S
    while time.monotonic() < until_s:
        try:
            datagram = client.recv(65_536)
        except TimeoutError:
            continue
        for _, message in wire.decode(datagram):
            if type(message) not in first:
                first[type(message)] = time.monotonic() - began_s
                if isinstance(message, wire.Pointer):
                    arrived.clear()
                    until_s = time.monotonic() + LISTEN_S
            if isinstance(message, wire.Frame):  # a frame may be sent again
                arrived.setdefault(message.frame, time.monotonic())
            health = message if isinstance(message, wire.Health) else health
    if wire.Pointer not in first:
        sys.exit(f"no pointer within {START_S:.0f} s; is the machine busy? See 'halo doctor'")
    print(f"first frame {first[wire.Frame]:.1f} s, first pointer {first[wire.Pointer]:.1f} s")
    times = sorted(arrived.values())
    long = sum(after - before > GAP_S for before, after in pairwise(times))
    print(
        f"{len(times) / LISTEN_S:.1f} frames a second over {LISTEN_S:.0f} s, "
        f"{long / max(len(times) - 1, 1):.1%} of the gaps over {1000 * GAP_S:.0f} ms"
    )
    if health is not None:
        print(
            f"received -> sent {health.latency_ms:.1f} ms, hands {health.tracker_ms:.0f} ms old, "
            f"{health.looks_hz:.0f} looks a second, load {wire.Load(health.load).name.lower()}"
        )


if __name__ == "__main__":
    main()
