"""TUIO 1.1: `/tuio/2Dcur` for fingers that touch, `/tuio/25Dcur` for all, with their height.

Each bundle has source, the full alive list, its cursors and a frame number. Velocities are in
surfaces per second; the acceleration is not known and 0. z is 1.0 at a height of 100 mm.
"""

from __future__ import annotations

import halo_protocol as wire
from halo_service.outputs.formats.packing import BUNDLE_HEAD, shared_out, template
from halo_service.outputs.formats.tuio_ids import MM_PER_UNIT, TuioIds, clamped
from halo_service.outputs.outgoing import OutgoingFrame, OutgoingReport

CUR_2D, CUR_25D = "/tuio/2Dcur", "/tuio/25Dcur"
_SET_2D = template(CUR_2D, "ifffff", "set")
_SET_25D = template(CUR_25D, "ifffffff", "set")


class Tuio11Format:
    """Two cursor profiles."""

    def __init__(self) -> None:
        self._ids = TuioIds()

    def frame(self, frame: OutgoingFrame) -> list[bytes]:
        """Return the bundles of both profiles."""
        first = self._ids.next_frame(frame.header.time_us)
        touching = [p for p in frame.pointers if p.touching]
        flat = self._profile(frame, CUR_2D, touching, [self._set_2d(frame, p) for p in touching])
        every = frame.pointers
        tall = self._profile(frame, CUR_25D, every, [self._set_25d(frame, p) for p in every])
        bodies = [*flat, *tall]
        numbers = [first, *(self._ids.next_frame(frame.header.time_us) for _ in bodies[1:])]
        return [
            body + template(address, "i", "fseq").pack(number)
            for (address, body), number in zip(bodies, numbers, strict=True)
        ]

    def report(self, report: OutgoingReport) -> list[bytes]:
        """TUIO has no place for reports."""
        del report
        return []

    def _profile(
        self,
        frame: OutgoingFrame,
        address: str,
        pointers: list[wire.Pointer] | tuple[wire.Pointer, ...],
        cursors: list[bytes],
    ) -> list[tuple[str, bytes]]:
        """Bundles without their frame number, with the address of the profile."""
        source = template(address, "", "source", f"halo@{frame.header.node}").pack()
        ids = [self._ids.of(pointer.id) for pointer in pointers]
        head = BUNDLE_HEAD + source + template(address, "i" * len(ids), "alive").pack(*ids)
        room = frame.max_bytes - len(head) - template(address, "i", "fseq").size
        return [(address, head + b"".join(part)) for part in shared_out(cursors, room)]

    def _set_2d(self, frame: OutgoingFrame, p: wire.Pointer) -> bytes:
        width_mm, height_mm = frame.size_mm
        speed = p.vx_mm_s / width_mm, p.vy_mm_s / height_mm
        return _SET_2D.pack(self._ids.of(p.id), clamped(p.u), clamped(p.v), *speed, 0.0)

    def _set_25d(self, frame: OutgoingFrame, p: wire.Pointer) -> bytes:
        width_mm, height_mm = frame.size_mm
        place = clamped(p.u), clamped(p.v), clamped(p.hover_mm / MM_PER_UNIT)
        speed = p.vx_mm_s / width_mm, p.vy_mm_s / height_mm, 0.0
        return _SET_25D.pack(self._ids.of(p.id), *place, *speed, 0.0)
