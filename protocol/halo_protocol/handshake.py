"""The messages with which a client asks for the stream on the control port.

Rule: bytes only; `SPEC.md` states who sends what when.
"""

from __future__ import annotations

import struct

from halo_protocol.names import ROOT
from halo_protocol.osc import padded
from halo_protocol.version import VERSION

CONTROL = f"{ROOT}control/"
HELLO, LEASE, GOODBYE = (CONTROL + each for each in ("hello", "lease", "goodbye"))
WELCOME, EXPIRED = CONTROL + "welcome", CONTROL + "expired"
LEAST_HELLO = 256
"""Bytes of a hello, filled up by its padding: no answer is larger than its question."""


def hello(stream: str, port: int = 0) -> bytes:
    """A hello that asks for a stream; port 0 is the sender's."""
    head = padded(HELLO) + padded(",ssis") + padded(VERSION) + padded(stream)
    head += struct.pack(">i", port)
    return head + padded("." * max(0, LEAST_HELLO - 4 - len(head)))


def with_token(address: str, token: str) -> bytes:
    """A lease, goodbye or expired with its token."""
    return padded(address) + padded(",s") + padded(token)
