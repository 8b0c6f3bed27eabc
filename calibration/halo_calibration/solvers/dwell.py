"""Touches at prompted places, before the finger's halo is calibrated. Pure.

A finger that touches a prompted place stays there: it is still for a moment, and the
surface around it shows a halo. A lift separates one touch from the next.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable

import numpy as np

from halo_calibration.observe import Observation
from halo_calibration.solvers.touch import NO_HALO_MM_PX, nail_length_mm
from halo_service.profile import Profile
from halo_service.sensing.nail import pad_under_nail

STILL_S = 0.4
"""A finger is still at the end of a tap for less than that; chosen."""
STILL_MM = 3.0
"""All of its places in that time lie this near to their middle: the fingertip is found to 2 mm."""
LEAST_SEEN = 0.7
"""Share of that time's frames in which the finger must be found, with a halo."""
LEAST_OF_TOUCH = 0.4
"""Of the halo of a touch that is known: it fades by a third towards the edges, and a finger that
hovers at 10 mm shows less than a quarter."""
LIFTED = 0.5
"""Of the halo that it rested with: below, the finger has been lifted."""
APART_MM = 25.0
"""A finger that is found so far away has been lifted meanwhile."""

Place = tuple[float, float]
"""x and y on the surface, mm."""


class Dwells:
    """Finds touches in the observations as they arrive."""

    def __init__(
        self, fps: float, least_raw: float = NO_HALO_MM_PX, nail_mm: float | None = None
    ) -> None:
        """`least_raw`: the weakest halo that is a touch, mm px; `nail_mm`: None where unknown."""
        self._nail_mm = nail_mm
        self._frames = round(STILL_S * fps)
        self._least_raw = least_raw
        self._strongest = 0.0
        self._recent: deque[Observation | None] = deque(maxlen=self._frames)
        self._resting: Observation | None = None
        """The finger as it was taken, until it is lifted."""

    def take(self, seen: Observation | None) -> Place | None:
        """Process one frame's finger; return where a touch was, once for each."""
        if self._resting is not None:
            if seen is None or not self._lifted(seen, self._resting):
                return None
            self._resting = None
            self._recent.clear()
        self._recent.append(seen)
        down = [each for each in self._recent if each is not None and each.raw >= self._least()]
        if len(down) < LEAST_SEEN * self._frames:
            return None
        where = np.array([(each.x_mm, each.y_mm) for each in down])
        middle = np.median(where, axis=0)
        if np.hypot(*(where - middle).T).max() > STILL_MM:
            return None
        raw = float(np.median([each.raw for each in down]))
        self._strongest = max(self._strongest, raw)
        self._resting = min(down, key=lambda each: abs(each.raw - raw))
        pitch, yaw = (
            float(np.median(angles))
            for angles in zip(*((each.pitch_deg, each.yaw_deg) for each in down), strict=True)
        )
        nail_mm = nail_length_mm(down) if self._nail_mm is None else self._nail_mm
        return pad_under_nail((float(middle[0]), float(middle[1])), pitch, yaw, nail_mm)

    def _least(self) -> float:
        return max(self._least_raw, LEAST_OF_TOUCH * self._strongest)

    def _lifted(self, seen: Observation, rested: Observation) -> bool:
        apart = np.hypot(seen.x_mm - rested.x_mm, seen.y_mm - rested.y_mm)
        return bool(apart > APART_MM or seen.raw < LIFTED * rested.raw)


def dwells_for(profile: Profile, fps: float) -> Dwells:
    """Find touches with the halo levels of this finger."""
    if profile.touch is None:
        return Dwells(fps)
    least_raw = max(NO_HALO_MM_PX, LEAST_OF_TOUCH * profile.touch.touch.raw)
    return Dwells(fps, least_raw, profile.touch.nail_mm)


def touches(seen: Iterable[Observation | None], dwells: Dwells, count: int) -> list[Place]:
    """Return the first `count` touches, or as many as there are."""
    places: list[Place] = []
    for each in seen:
        place = dwells.take(each)
        if place is not None:
            places.append(place)
        if len(places) == count:
            break
    return places
