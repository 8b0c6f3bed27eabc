"""Noise of the live virtual camera, at a fraction of the cost.

Rule: statistics of the noise, single frames and everything near a body are as in `noise`. But the
empty room around it is not drawn for each frame: images of it return, every half second.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from halo_service.virtual.depth_image import Ideal
from halo_service.virtual.noise import DepthNoise, Electronics
from halo_service.virtual.optics import WIDEST_SHADOW_PX

Read = NDArray[np.uint16]

READS = 16
"""Images of the empty room that return in turn: each half a second later at 30 frames a second."""
RENEWED = 9
"""One of so many frames replaces the oldest image: a mean over seconds has no lasting error, and
images follow the drift. It shares no factor with `READS`, so each image is replaced in its turn."""


class LiveElectronics(Electronics):
    """Electronics that read the empty room less often."""

    def furnish(self, empty: Ideal) -> None:
        """As `Electronics.furnish`; images of the room before are forgotten."""
        super().furnish(empty)
        self._light = empty.infrared
        self._depths, self._infrareds = _Reads(), _Reads()

    def empty_depth(self, noise: DepthNoise) -> Read:
        """As `Electronics.empty_depth`, or one that was read before."""
        return self._depths.next(lambda: super(LiveElectronics, self).empty_depth(noise))

    def infrared(self, seen: Ideal, rng: np.random.Generator) -> Read:
        """As `Electronics.infrared`, where bodies and their shadows are."""
        noise = self.infrared_noise(rng)
        read = self._infrareds.next(lambda: noise.whole(self._light))
        lit = seen.around(WIDEST_SHADOW_PX)
        if lit is not None:
            read[lit] = noise.read(seen.infrared[lit], lit)
        return read


class _Reads:
    """Images that return in turn."""

    def __init__(self) -> None:
        self._reads: deque[Read] = deque(maxlen=READS)
        self._count = 0

    def next(self, draw: Callable[[], Read]) -> Read:
        """A copy of the image that was used longest ago, or a new one."""
        if len(self._reads) < READS or self._count % RENEWED == 0:
            self._reads.append(draw())
        else:
            self._reads.rotate(-1)
        self._count += 1
        return self._reads[-1].copy()
