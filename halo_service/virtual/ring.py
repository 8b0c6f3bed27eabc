"""A few frames in shared memory, the newest of them readable at any time.

Rule: one writer, one reader, no waiting. The writer marks a slot as torn (odd) before it writes
and as whole (even) after; a reader that sees the mark change meanwhile throws its copy away.
"""

from __future__ import annotations

from multiprocessing.shared_memory import SharedMemory

import numpy as np
from numpy.typing import NDArray

from halo_service.geometry.camera import Lens
from halo_service.values import Frame

SLOTS = 3
_COLOUR = 720, 1280, 3
_HEAD = 64 * (SLOTS + 1)


def ring_bytes(lens: Lens) -> int:
    """Size of the memory for frames of this depth lens."""
    return _HEAD + SLOTS * _slot_bytes(lens)


def _slot_bytes(lens: Lens) -> int:
    return 4 * lens.height * lens.width + int(np.prod(_COLOUR))


class Ring:
    """A view of the memory; numbers count from 1, 0 is "nothing yet"."""

    def __init__(self, shared: SharedMemory, lens: Lens) -> None:
        """`lens`: of the depth images."""
        memory = shared.buf
        assert memory is not None  # it is only once the memory has been closed
        self._head: NDArray[np.int64] | None = np.ndarray((SLOTS + 1, 8), np.int64, memory)
        starts = [_HEAD + slot * _slot_bytes(lens) for slot in range(SLOTS)]
        self._slots = [self._views(memory, start, lens) for start in starts]

    @staticmethod
    def _views(
        memory: memoryview, at: int, lens: Lens
    ) -> tuple[NDArray[np.uint16], NDArray[np.uint16], NDArray[np.uint8]]:
        shape = lens.height, lens.width
        image = 2 * lens.height * lens.width
        return (
            np.ndarray(shape, np.uint16, memory, at),
            np.ndarray(shape, np.uint16, memory, at + image),
            np.ndarray(_COLOUR, np.uint8, memory, at + 2 * image),
        )

    def write(self, number: int, frame: Frame) -> None:
        """Put frame `number` (from 1 up) over the oldest one."""
        assert self._head is not None
        slot = number % SLOTS
        row = self._head[1 + slot]
        row[0] += 1
        depth, ir, colour = self._slots[slot]
        np.copyto(depth, frame.depth)
        np.copyto(ir, frame.ir)
        has_colour = isinstance(frame.colour, np.ndarray)
        if isinstance(frame.colour, np.ndarray):
            np.copyto(colour, frame.colour)
        row[1:4] = number, frame.time_us, has_colour
        row[0] += 1
        self._head[0, 0] = number

    def newest(self, after: int) -> tuple[int, Frame] | None:
        """A copy of the newest frame and its number, or None when it is not newer than `after`."""
        assert self._head is not None
        for _ in range(8):
            newest = int(self._head[0, 0])
            if newest <= after:
                return None
            row = self._head[1 + newest % SLOTS]
            mark = int(row[0])
            depth, ir, colour = self._slots[newest % SLOTS]
            number, time_us, has_colour = (int(v) for v in row[1:4])
            frame = Frame(time_us, depth.copy(), ir.copy(), colour.copy() if has_colour else None)
            if mark % 2 == 0 and int(row[0]) == mark and number == newest:
                return number, frame
        return None

    def release(self) -> None:
        """Let go of the memory, so that it can be closed."""
        self._head = None
        self._slots = []
