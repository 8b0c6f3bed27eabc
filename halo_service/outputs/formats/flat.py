"""One number per address, for node tools: `/halo/1/table/slot/0/pressure 0.42`.

A slot without a finger has touch 0 and hover -1, in every frame, so that a lost datagram leaves no
finger behind.
"""

from __future__ import annotations

import struct
from collections.abc import Iterator
from functools import lru_cache

import halo_protocol as wire
from halo_service.outputs.formats.packing import Template, bundles
from halo_service.outputs.outgoing import OutgoingFrame, OutgoingReport

VALUES = (
    ("u", "f"), ("v", "f"), ("x_mm", "f"), ("y_mm", "f"), ("hover", "f"), ("pressure", "f"),
    ("touch", "i"), ("force_g", "f"), ("vx", "f"), ("vy", "f"), ("strike", "f"), ("id", "i"),
)  # fmt: skip
"""Name and type of a slot's values."""
GONE = (("hover", "f", -1.0), ("touch", "i", 0))
"""Values of a slot without a finger."""
FRESH_MS = 250.0
"""An event in its three frames is younger, at 15 frames a second too."""
SLOTS = 10
"""Slots that every frame reports as free or used; a service uses 0 to 9."""
REFRESH_US = 1_000_000
"""With `changes`, all values are sent again after so long, which replaces lost ones."""


class FlatFormat:
    """Values of slots; can send only changes."""

    def __init__(self, *, bundles: bool = True, changes: bool = False) -> None:
        self._bundles = bundles
        self._changes = changes
        self._sent: dict[bytes, bytes] = {}
        self._refreshed_us = float("-inf")

    def frame(self, frame: OutgoingFrame) -> list[bytes]:
        """Return the values of all slots, and `count`."""
        chunks = list(_chunks(frame))
        if self._bundles and not self._changes:
            return bundles(chunks, frame.max_bytes)
        elements = [element for chunk in chunks for element in _elements(chunk)]
        if self._changes:
            elements = self._changed(elements, frame.header.time_us)
        if self._bundles:
            return bundles(elements, frame.max_bytes)
        return [element[4:] for element in elements]

    def report(self, report: OutgoingReport) -> list[bytes]:
        """Reports have no numbers for node tools."""
        del report
        return []

    def _changed(self, elements: list[bytes], now_us: int) -> list[bytes]:
        if not 0 <= now_us - self._refreshed_us < REFRESH_US:
            self._refreshed_us = now_us
            self._sent.clear()
        changed = [each for each in elements if self._sent.get(each[:-4]) != each]
        self._sent.update((each[:-4], each) for each in changed)
        return changed


def _chunks(frame: OutgoingFrame) -> Iterator[bytes]:
    """The elements of each slot, then `count`."""
    # Not one that is sent once more much later: a reader without numbers would hit again.
    fresh = (down for down in frame.downs if down.ago_ms < FRESH_MS)
    strikes = {down.id: down.strike_mm_s for down in fresh}
    used = set()
    for p in frame.pointers:
        used.add(p.slot)
        numbers = (
            p.u, p.v, p.x_mm, p.y_mm, p.hover_mm, p.pressure, int(p.touching), p.force_g,
            p.vx_mm_s, p.vy_mm_s, strikes.get(p.id, 0.0), p.id,
        )  # fmt: skip
        yield _slot(frame.surface, p.slot).pack(numbers)
    for slot in range(SLOTS):
        if slot not in used:
            yield _gone(frame.surface, slot)
    yield _count(frame.surface).pack(len(frame.pointers))


class _Slot:
    """All values of a slot, packed at once."""

    def __init__(self, surface: str, slot: int) -> None:
        heads = [
            Template(wire.address(surface, f"slot/{slot}/{name}"), tag).pack(0)[:-4]
            for name, tag in VALUES
        ]
        form = "".join(f"{len(head)}s{tag}" for head, (_, tag) in zip(heads, VALUES, strict=True))
        self._struct = struct.Struct(f">{form}")
        self._arguments: list[bytes | float] = [part for head in heads for part in (head, 0.0)]

    def pack(self, numbers: tuple[float, ...]) -> bytes:
        self._arguments[1::2] = numbers
        return self._struct.pack(*self._arguments)


@lru_cache(maxsize=256)
def _slot(surface: str, slot: int) -> _Slot:
    return _Slot(surface, slot)


@lru_cache(maxsize=256)
def _gone(surface: str, slot: int) -> bytes:
    return b"".join(
        Template(wire.address(surface, f"slot/{slot}/{name}"), tag).pack(value)
        for name, tag, value in GONE
    )


@lru_cache(maxsize=16)
def _count(surface: str) -> Template:
    return Template(wire.address(surface, "count"), "i")


def _elements(chunk: bytes) -> Iterator[bytes]:
    """Split a chunk into its elements."""
    start = 0
    while start < len(chunk):
        (size,) = struct.unpack_from(">i", chunk, start)
        yield chunk[start : start + 4 + size]
        start += 4 + size
