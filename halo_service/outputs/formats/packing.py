"""Messages of formats other than `frames`, and how they share bundles.

Rule: the constant bytes of a message are made once; a frame only packs its numbers.
"""

from __future__ import annotations

import struct
from collections.abc import Iterable
from functools import lru_cache

from halo_protocol.osc import BUNDLE, IMMEDIATELY, padded

BUNDLE_HEAD = BUNDLE + IMMEDIATELY


class Template:
    """A bundle element: an address, constant strings, then numbers."""

    def __init__(self, address: str, tags: str, *strings: str) -> None:
        """`tags`: those of the numbers; `t` is a timetag as an int."""
        constant = padded(address) + padded(f",{'s' * len(strings)}{tags}")
        constant += b"".join(map(padded, strings))
        numbers = tags.replace("t", "Q")
        size = len(constant) + struct.calcsize(f">{numbers}")
        self._head = struct.pack(">i", size) + constant
        self._struct = struct.Struct(f">{len(self._head)}s{numbers}")
        self.size = 4 + size

    def pack(self, *numbers: float) -> bytes:
        """Return the element, with its size in front."""
        return self._struct.pack(self._head, *numbers)


@lru_cache(maxsize=256)
def template(address: str, tags: str, *strings: str) -> Template:
    """Return the template of a message, made once."""
    return Template(address, tags, *strings)


def bundles(elements: Iterable[bytes], max_bytes: int) -> list[bytes]:
    """Share elements among bundles of at most `max_bytes`, each filled before the next."""
    parts: list[list[bytes]] = []
    left = 0
    for each in elements:
        if not parts or len(each) > left:
            parts.append([BUNDLE_HEAD])
            left = max_bytes - len(BUNDLE_HEAD)
        parts[-1].append(each)
        left -= len(each)
    return [b"".join(part) for part in parts]


def shared_out(elements: list[bytes], room: int) -> list[list[bytes]]:
    """Split elements of one size into parts of at most `room` bytes; at least one part."""
    per_part = max(1, room // len(elements[0])) if elements else 1
    return [elements[n : n + per_part] for n in range(0, len(elements), per_part)] or [[]]
