"""Ports for programs that open them a moment later."""

from __future__ import annotations

import os
import random
import socket
from itertools import cycle

COUNT = 1_000
"""Of each process of the tests, so that two never try the same one."""
FIRST = 20_000 + COUNT * (int(os.environ.get("PYTEST_XDIST_WORKER", "gw9")[2:]) % 10)
"""All are below those that a system gives to programs that ask for any port: such a program,
started in between, would get it."""
_START = random.SystemRandom().randrange(COUNT)  # two runs on one machine
_PORTS = cycle(FIRST + (_START + n) % COUNT for n in range(COUNT))


def free_port() -> int:
    """Return a port that is free for TCP and UDP, another one each time."""
    return next(filter(_is_free, _PORTS))


def _is_free(port: int) -> bool:
    try:
        for kind in (socket.SOCK_STREAM, socket.SOCK_DGRAM):
            with socket.socket(socket.AF_INET, kind) as probe:
                probe.bind(("", port))
    except OSError:
        return False
    return True
