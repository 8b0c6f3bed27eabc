"""A client in its own process that receives packets and counts them.

`python -m halo_service.evaluation.latency.listener` writes its port, then, for each line that it
reads, one line of JSON with what it has received since the last.
"""

from __future__ import annotations

import json
import select
import socket
import subprocess
import sys
from dataclasses import dataclass

import halo_protocol as wire

QUIET_S = 0.2
"""After so long without a packet all have arrived: it is one machine."""


@dataclass(frozen=True, slots=True)
class Received:
    """What arrived."""

    datagrams: int
    frames: int
    """Different frames among them."""


class Listener:
    """Starts the client; a context manager."""

    def __init__(self) -> None:
        self._process = subprocess.Popen(
            [sys.executable, "-m", __name__],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
        )
        self.port = int(self._line())

    def received(self) -> Received:
        """What has arrived since the last call."""
        assert self._process.stdin is not None
        self._process.stdin.write("\n")
        self._process.stdin.flush()
        return Received(**json.loads(self._line()))

    def close(self) -> None:
        """End the client."""
        self._process.communicate()

    def __enter__(self) -> Listener:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _line(self) -> str:
        assert self._process.stdout is not None
        return self._process.stdout.readline()


def main() -> None:
    """Listen until stdin ends."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as client:
        client.bind(("127.0.0.1", 0))
        _write(str(client.getsockname()[1]))
        datagrams, frames = 0, set[tuple[str, int]]()
        reporting = False
        while True:
            ready, _, _ = select.select([client, sys.stdin], [], [], QUIET_S if reporting else None)
            if client in ready:
                datagrams += 1
                frames |= _frames(client.recv(65_536))
            elif sys.stdin in ready:
                if not sys.stdin.readline():
                    return
                reporting = True
            elif reporting:
                _write(json.dumps({"datagrams": datagrams, "frames": len(frames)}))
                datagrams, frames, reporting = 0, set(), False


def _write(line: str) -> None:
    sys.stdout.write(line + "\n")
    sys.stdout.flush()


def _frames(datagram: bytes) -> set[tuple[str, int]]:
    messages = (message for _, message in wire.decode(datagram))
    return {(each.session, each.frame) for each in messages if isinstance(each, wire.Frame)}


if __name__ == "__main__":
    main()
