"""The sensor's own curves, measured on its frames as the paper measures a real camera's.

Rule: frames in, numbers out; this is how the virtual camera is judged, not how touch is sensed.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from halo_service.values import Finger
from halo_service.virtual.hand import pointing
from halo_service.virtual.room import HEIGHT_MM, WIDTH_MM, Room
from halo_service.virtual.sensor import Sensor
from halo_service.virtual.skeleton import FingerPose, PosedHand, posed

THRESHOLD_MM = 8.0
"""The paper's (4.3.1)."""
PATCH_PX = 30, 20
"""The paper's patch around the fingertip (4.3.3), along the finger and across."""
STATES = {
    "hover": (10.0, 0.0),
    "subtle": (1.0, 0.0),
    "touch": (0.0, 25.0),
    "pressure": (0.0, 200.0),
}
"""The four calibration states (4.3.5) as height in mm and force in g; the forces are chosen."""
PITCH_DEG = 30.0
"""Of the finger where nothing else is said: flat enough that a camera tilted by 45 degrees, which
looks over the hand's back, still sees the fingertip. The paper does not say which it had."""
EMPTY_FRAMES, FRAMES = 20, 6


@dataclass(frozen=True, slots=True)
class Regions:
    """How far apart neighbouring states are: what the paper calls sensing regions (4.4)."""

    hover: float
    touch: float
    pressure: float

    def relative(self, reference: Regions) -> Regions:
        """As shares of a reference."""
        return Regions(
            self.hover / reference.hover,
            self.touch / reference.touch,
            self.pressure / reference.pressure,
        )


def background(frames: Sequence[NDArray[np.uint16]]) -> NDArray[np.float64]:
    """(H, W) mean depth of an empty table, mm; infinite where it is mostly not measured."""
    stack = np.array(frames)
    seen = np.count_nonzero(stack, axis=0)
    total = stack.sum(axis=0, dtype=np.float64)
    return np.where(seen > len(stack) // 2, total / np.maximum(seen, 1), np.inf)


class Bench:
    """One room and its empty background."""

    def __init__(self, room: Room) -> None:
        self._room = dataclasses.replace(room, projected=None)
        self._sensor = Sensor(self._room, colour_times=0)
        self._time_us = 0
        self._background = background([self._read([]) for _ in range(EMPTY_FRAMES)])

    def signal(
        self,
        height_mm: float,
        force_g: float = 0.0,
        pitch_deg: float = PITCH_DEG,
        yaw_deg: float = 0.0,
        threshold_mm: float = THRESHOLD_MM,
    ) -> float:
        """Sum of what reads deeper than the threshold in the patch, mm, mean over some frames."""
        hand = self._hand(FingerPose(0.0, 0.0, height_mm, force_g, pitch_deg, yaw_deg))
        rows, columns = self._patch(hand, yaw_deg)
        sums = []
        for _ in range(FRAMES):
            excess = self._read([hand]).astype(np.float64)[rows, columns]
            excess = np.where(excess > 0.0, excess - self._background[rows, columns], 0.0)
            sums.append(excess[excess > threshold_mm].sum())
        return float(np.mean(sums))

    def dent_mm(self, height_mm: float) -> float:
        """Mean depth of the table's dent next to a hovering fingertip, without a threshold."""
        hand = self._hand(FingerPose(0.0, 0.0, height_mm))
        rows, columns = self._patch(hand, 0.0)
        reads = np.array([self._read([hand])[rows, columns] for _ in range(4 * FRAMES)])
        excess = reads.mean(axis=0) - self._background[rows, columns]
        # The finger itself reads nearer, its outline something between: the deepest fifth is dent.
        beside = np.sort(excess[(reads > 0).all(axis=0)])
        return float(beside[-len(beside) // 5 :].mean())

    def states(self, **how: float) -> dict[str, float]:
        """Signal of each of the four states."""
        return {name: self.signal(*state, **how) for name, state in STATES.items()}

    def regions(self, **how: float) -> Regions:
        """Differences of neighbouring states."""
        at = self.states(**how)
        return Regions(
            at["subtle"] - at["hover"], at["touch"] - at["subtle"], at["pressure"] - at["touch"]
        )

    def _hand(self, aim: FingerPose) -> PosedHand:
        middle = dataclasses.replace(aim, x_mm=WIDTH_MM / 2.0, y_mm=HEIGHT_MM / 2.0)
        room = self._room
        return posed(room.user, pointing(room.user, room.dominant, middle, curl=room.user.curl))

    def _patch(self, hand: PosedHand, yaw_deg: float) -> tuple[slice, slice]:
        """Around the pad; the long side lies along the finger, as well as a box can."""
        pad = hand.pad(Finger.INDEX)
        pad[2] = min(pad[2], 0.0)
        x, y = self._sensor.camera.depth.project(self._sensor.surface.to_camera(pad[None]))[0]
        long, short = PATCH_PX
        tall, wide = (long, short) if abs(yaw_deg) < 45.0 else (short, long)
        top, left = round(y) - tall // 2, round(x) - wide // 2
        return slice(top, top + tall), slice(left, left + wide)

    def _read(self, hands: list[PosedHand]) -> NDArray[np.uint16]:
        self._time_us += round(1e6 / self._sensor.camera.fps)
        return self._sensor.frame(self._time_us, hands).depth
