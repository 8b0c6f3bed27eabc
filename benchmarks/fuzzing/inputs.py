"""Random and changed datagrams, HTTP requests and WebSocket messages.

Rule: pure, and the same for the same seed. Random bytes alone would never pass the first check, so
most inputs are valid ones with some bytes changed, removed or inserted.
"""

from __future__ import annotations

import json
import random
import struct
from collections.abc import Iterator
from pathlib import Path

from halo_protocol import VERSION
from halo_protocol.handshake import CONTROL, EXPIRED, GOODBYE, LEASE, WELCOME, hello
from halo_protocol.osc import BUNDLE, padded
from halo_protocol.table import ROWS

VECTORS = Path(__file__).parents[2] / "protocol" / "vectors" / VERSION.rpartition(".")[0]
HOST = "127.0.0.1:{port}"


def osc(address: str, *arguments: str | int | float) -> bytes:
    """Return one OSC message."""
    tags, packed = ",", b""
    for argument in arguments:
        if isinstance(argument, str):
            tags, packed = tags + "s", packed + padded(argument)
        else:
            tag = "f" if isinstance(argument, float) else "i"
            tags, packed = tags + tag, packed + struct.pack(f">{tag}", argument)
    return padded(address) + padded(tags) + packed


def _golden() -> Iterator[bytes]:
    for name in ("frames", "reports", "readings", "malformed"):
        for vector in json.loads((VECTORS / f"{name}.json").read_text())["vectors"]:
            for holder in vector.get("datagrams", [vector]):
                yield bytes.fromhex(holder["hex"])


CONTROLS = (
    hello("frames"),
    hello("flat,rate=30,surface=table"),
    hello("tuio2", 9),
    osc(LEASE, "t0123456789abcdef"),
    osc(GOODBYE, "t0123456789abcdef"),
    osc(WELCOME, "desk", "s1", "1.0.0", "accepted", "t0", "", 10_000),
    osc(EXPIRED, "t0"),
    osc(f"{CONTROL}pause", 1),
    osc(f"{CONTROL}resume"),
    osc(f"{CONTROL}background", 1.0),
    osc(f"{CONTROL}profile", "../../etc/passwd"),
    osc(f"{CONTROL}sensing/up_level", 0.1),
    osc(f"{CONTROL}sensing/fingers", "all"),
    osc(f"{CONTROL}status", "." * 256),
    osc("/halo/1/sim/finger", 0.5, 0.5, 0.0),
)
SEEDS = (*sorted(set(_golden())), *CONTROLS)
PIECES = (
    BUNDLE,
    bytes(8),
    b"\0\0\0\x14",
    b"\xff\xff\xff\xff",
    b"\x7f\xc0\0\0",
    b"\x7f\xff\xff\xff",
    padded("desk"),
    *(padded(f"/halo/1/table/{row.kind}") for row in ROWS),
    *(padded(f",{row.tags}") for row in ROWS),
    padded(",[]TFNIhdtcrmSb"),
)
UPGRADE = (
    b"GET /halo HTTP/1.1\r\nHost: 127.0.0.1\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
    b"Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n"
    b"Sec-WebSocket-Protocol: halo.1.osc\r\n\r\n"
)
REQUESTS = (
    UPGRADE,
    UPGRADE + b"\x81\xfe\x10\x00abcd" + bytes(300),
    b"GET / HTTP/1.1\r\nHost: localhost\r\n\r\n",
    b"GET /?HOST_INFO HTTP/1.1\r\nHost: localhost\r\nOrigin: http://[::1]:80\r\n\r\n",
    b"GET /halo/1/table/slot/0/touch?VALUE HTTP/1.1\r\nHost: localhost\r\n\r\n",
    b"GET /%2e%2e/halo/%00?RANGE HTTP/1.0\r\nHost: 127.0.0.1\r\n\r\n",
    b"POST /halo HTTP/1.1\r\nHost: localhost\r\nContent-Length: 5\r\n\r\nhello",
    b"PUT / HTTP/1.1\r\nHost: localhost\r\nTransfer-Encoding: chunked\r\n\r\n"
    b"5\r\nhello\r\n0\r\n\r\n",
)
TEXTS = (
    '{"kind":"control","address":"/halo/1/control/pause","arguments":[]}',
    '{"kind":"control","address":"/halo/1/control/sensing/up_level","arguments":[0.1]}',
    '{"kind":"control","address":"/halo/1/control/hello","arguments":["1.0.0","frames,rate=30"]}',
    '{"kind":"control","address":"/halo/1/control/status","arguments":["é\\u0000",1e400,-0]}',
    '{"kind":"control","address":"/x","arguments":[[[]]]}',
    "[" * 2000,
    "null",
)


class Inputs:
    """An endless supply."""

    def __init__(self, seed: int) -> None:
        self._chance = random.Random(seed)

    def datagram(self) -> bytes:
        """Return a datagram: noise, pieces of OSC, or a valid one that was changed."""
        chance = self._chance
        kind = chance.random()
        if kind < 0.1:
            return chance.randbytes(chance.randrange(0, 300))
        if kind < 0.2:
            pieces = chance.choices(PIECES, k=chance.randrange(1, 20))
            return b"".join(pieces)
        return self._mutated(chance.choice(SEEDS), PIECES)

    def request(self) -> bytes:
        """Return the bytes of an HTTP connection."""
        chance = self._chance
        if chance.random() < 0.1:
            return chance.randbytes(chance.randrange(1, 300))
        pieces = (b"\r\n", b"\0", b": ", b"%", b"/../", b"HTTP/9.9", b"\xff\xfe", b"?", b"A" * 9000)
        return self._mutated(chance.choice(REQUESTS), pieces)

    def message(self) -> bytes | str:
        """Return a WebSocket message, binary or text."""
        chance = self._chance
        if chance.random() < 0.5:
            return self.datagram()[: chance.choice([100, 9000])]
        pieces = (
            b"{",
            b"]",
            b'"',
            b"\\u0000",
            b"NaN",
            b"1e999",
            b"null",
            "ä".encode(),
            b"9" * 5000,
        )
        raw = self._mutated(chance.choice(TEXTS).encode(), pieces)
        return raw.decode("utf-8", "replace")

    def _mutated(self, raw: bytes, pieces: tuple[bytes, ...]) -> bytes:
        chance, changed = self._chance, bytearray(raw)
        for _ in range(chance.randrange(0, 5)):
            at = chance.randrange(len(changed) + 1)
            match chance.randrange(3):
                case 0:
                    changed[at : at + 1] = chance.randbytes(1)
                case 1:
                    changed[at : at + chance.choice([0, 4, 8])] = chance.choice(pieces)
                case _:
                    del changed[at : at + chance.choice([1, 4, 200])]
        return bytes(changed)
