"""TUIO 2.0: `/tuio2/ptr` between `/tuio2/frm` and `/tuio2/alv`.

`press` is the pressure of a finger that touches, and minus its height (100 mm: -1.0) of one that
hovers. The type is the finger: right index 1, middle 2, ring 3, little 4, thumb 5, left 6 to 10.
"""

from __future__ import annotations

import struct

import halo_protocol as wire
from halo_protocol.osc import padded, timetag
from halo_service.outputs.formats.packing import BUNDLE_HEAD, shared_out, template
from halo_service.outputs.formats.tuio_ids import MM_PER_UNIT, TuioIds, clamped
from halo_service.outputs.outgoing import OutgoingFrame, OutgoingReport

ALV = "/tuio2/alv"
_FRM = padded("/tuio2/frm") + padded(",itis")
_PTR = template("/tuio2/ptr", "iiifffffffffff")
_TYPE = {
    wire.Finger.INDEX: 1,
    wire.Finger.MIDDLE: 2,
    wire.Finger.RING: 3,
    wire.Finger.LITTLE: 4,
    wire.Finger.THUMB: 5,
}
LEFT = 5
"""Added for a finger of the left hand."""
NO_PRESS = 1e-6
"""The least press of a finger that touches: 0 would be neither touch nor hover."""


class Tuio2Format:
    """Pointers."""

    def __init__(self) -> None:
        self._ids = TuioIds()

    def frame(self, frame: OutgoingFrame) -> list[bytes]:
        """Return the bundles of a frame; each has a number of its own and the full alive list."""
        first = self._ids.next_frame(frame.header.time_us)
        pointers = [self._pointer(frame, pointer) for pointer in frame.pointers]
        ids = [self._ids.of(pointer.id) for pointer in frame.pointers]
        alive = template(ALV, "i" * len(ids)).pack(*ids)
        room = frame.max_bytes - len(BUNDLE_HEAD) - len(_frm(frame, first)) - len(alive)
        parts = shared_out(pointers, room)
        numbers = [first, *(self._ids.next_frame(frame.header.time_us) for _ in parts[1:])]
        return [
            b"".join((BUNDLE_HEAD, _frm(frame, number), *part, alive))
            for number, part in zip(numbers, parts, strict=True)
        ]

    def report(self, report: OutgoingReport) -> list[bytes]:
        """TUIO has no place for reports."""
        del report
        return []

    def _pointer(self, frame: OutgoingFrame, p: wire.Pointer) -> bytes:
        width_mm, height_mm = frame.size_mm
        press = max(p.pressure, NO_PRESS) if p.touching else -p.hover_mm / MM_PER_UNIT
        return _PTR.pack(
            self._ids.of(p.id), _kind(p), p.slot, clamped(p.u), clamped(p.v), 0.0, 0.0, 0.0, press,
            p.vx_mm_s / width_mm, p.vy_mm_s / height_mm, 0.0, 0.0, 0.0,
        )  # fmt: skip


def _frm(frame: OutgoingFrame, number: int) -> bytes:
    """Number, time, size of the surface in mm and name of the sender."""
    width_mm, height_mm = (round(size) % 2**15 for size in frame.size_mm)
    numbers = struct.pack(">i", number) + timetag(frame.header.time_us)
    numbers += struct.pack(">i", width_mm << 16 | height_mm)
    element = _FRM + numbers + padded(f"halo@{frame.header.node}")
    return struct.pack(">i", len(element)) + element


def _kind(p: wire.Pointer) -> int:
    """The finger as a TUIO pointer type; 0 where the hand is unknown."""
    if p.hand not in (wire.Hand.LEFT, wire.Hand.RIGHT) or p.finger not in list(wire.Finger):
        return 0
    return _TYPE[wire.Finger(p.finger)] + (LEFT if p.hand == wire.Hand.LEFT else 0)
