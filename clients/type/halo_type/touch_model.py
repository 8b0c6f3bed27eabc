"""Which key a touch meant: a probability over keys, without any language.

Rule: pure. A touch on a key is a normal distribution around the key's middle, shifted by how far
this user's touches were off so far. Its covariance starts as people's scatter and follows the
user's. A uniform density is for touches that mean no key; it weighs more where `confidence` is low.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field

from halo_type.layout import KEY_MM, Key

SIGMA_MM = 3.0
"""Scatter around the middle of a key before anything is known about the user, each way: aim 2 mm
(Azenkot and Zhai 2012) and place of the service 2 mm."""
PRIOR_KEYS = 12.0
"""Keystrokes that the first guess of offset and scatter counts for."""
FORGET = 1 / 200
"""Share of the older keystrokes that each new one replaces: a user who sits down differently."""
FAR_MM = 0.75 * KEY_MM
"""An offset is learned only from touches this near to their key's middle."""
ELSEWHERE = 1e-5
"""Density of touches that mean no key, 1/mm^2, at confidence 0: one in the area of a surface."""


@dataclass(slots=True)
class TouchModel:
    """What is known about how this user hits keys."""

    keys: Mapping[str, Key]
    _weight: float = PRIOR_KEYS
    _offset: list[float] = field(default_factory=lambda: [0.0, 0.0])
    _variance: list[float] = field(default_factory=lambda: [SIGMA_MM**2, SIGMA_MM**2])

    @property
    def offset_mm(self) -> tuple[float, float]:
        """How far touches land from the middle of keys, on average: right, and towards the user."""
        return self._offset[0], self._offset[1]

    def probabilities(self, x_mm: float, y_mm: float, confidence: float) -> dict[str | None, float]:
        """Return the probability of each key, and of None: no key was meant. They add up to 1."""
        density: dict[str | None, float] = {
            character: self._density(self._off(key, x_mm, y_mm))
            for character, key in self.keys.items()
        }
        density[None] = ELSEWHERE * (1.0 - min(max(confidence, 0.0), 0.99))
        whole = sum(density.values())
        return {character: each / whole for character, each in density.items()}

    def key_at(self, x_mm: float, y_mm: float, confidence: float) -> str | None:
        """Return the most probable key, or None; learn from the touch."""
        found = self.probabilities(x_mm, y_mm, confidence)
        character = max(found, key=lambda each: found[each])
        if character is not None:
            self._learn(self.keys[character], x_mm, y_mm)
        return character

    def _off(self, key: Key, x_mm: float, y_mm: float) -> tuple[float, float]:
        """How far a place is from a key's middle line, without the user's offset."""
        dx, dy = _from_middle(key, x_mm - self._offset[0], y_mm - self._offset[1])
        return dx, dy

    def _density(self, off: tuple[float, float]) -> float:
        exponent = sum(d * d / v for d, v in zip(off, self._variance, strict=True)) / 2.0
        return math.exp(-min(exponent, 700.0)) / (
            2.0 * math.pi * math.sqrt(math.prod(self._variance))
        )

    def _learn(self, key: Key, x_mm: float, y_mm: float) -> None:
        dx, dy = _from_middle(key, x_mm, y_mm)
        if math.hypot(dx, dy) > FAR_MM or key.width_mm > 1.5 * key.height_mm:
            return  # on a wide key, nothing says where it was aimed at
        self._weight = min(self._weight + 1.0, 1.0 / FORGET)
        for axis, off in enumerate((dx, dy)):
            error = off - self._offset[axis]
            self._offset[axis] += error / self._weight
            spread = error * error - self._variance[axis]
            self._variance[axis] += spread / self._weight


def _from_middle(key: Key, x_mm: float, y_mm: float) -> tuple[float, float]:
    """From the nearest point of the line along a wide key, of the middle of a square one."""
    half = max(0.0, (key.width_mm - key.height_mm) / 2.0)
    x, y = x_mm - key.middle[0], y_mm - key.middle[1]
    return math.copysign(max(abs(x) - half, 0.0), x), y
