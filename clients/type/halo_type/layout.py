"""A keyboard of letters on the surface: where the keys are, and which one a touch hits.

Rule: pure geometry, in mm on the surface, origin at its top left, y towards the user. The keys
are 16 mm squares, three rows of QWERTY and a space bar (letters only).
"""

from __future__ import annotations

from dataclasses import dataclass

KEY_MM = 16.0
ROWS = ("qwertyuiop", "asdfghjkl", "zxcvbnm")
SHIFT_KEYS = (0.0, 0.25, 0.75)
"""Offset of each row, in keys."""
SPACE = " "
SPACE_KEYS = (2.0, 5.0)
"""Start and width of the space bar, in keys."""
WIDTH_MM = 10 * KEY_MM
HEIGHT_MM = 4 * KEY_MM


@dataclass(frozen=True, slots=True)
class Key:
    """One key."""

    character: str
    x_mm: float
    y_mm: float
    """Its top left corner."""
    width_mm: float
    height_mm: float = KEY_MM

    @property
    def middle(self) -> tuple[float, float]:
        """Centre of the key, mm."""
        return self.x_mm + self.width_mm / 2.0, self.y_mm + self.height_mm / 2.0

    def inside(self, x_mm: float, y_mm: float) -> float:
        """How far inside the key a place lies, mm; negative outside."""
        across = min(x_mm - self.x_mm, self.x_mm + self.width_mm - x_mm)
        along = min(y_mm - self.y_mm, self.y_mm + self.height_mm - y_mm)
        return min(across, along)


def keyboard(x_mm: float, y_mm: float) -> dict[str, Key]:
    """All keys by their character, the keyboard's top left corner at a place."""
    keys = {}
    for row, letters in enumerate(ROWS):
        for column, letter in enumerate(letters):
            left = x_mm + (SHIFT_KEYS[row] + column) * KEY_MM
            keys[letter] = Key(letter, left, y_mm + row * KEY_MM, KEY_MM)
    begin, wide = SPACE_KEYS
    keys[SPACE] = Key(SPACE, x_mm + begin * KEY_MM, y_mm + 3 * KEY_MM, wide * KEY_MM)
    return keys


def key_at(keys: dict[str, Key], x_mm: float, y_mm: float) -> str | None:
    """The character of the key that a touch hits, or None outside all keys."""
    for character, key in keys.items():
        if key.x_mm <= x_mm < key.x_mm + key.width_mm and (
            key.y_mm <= y_mm < key.y_mm + key.height_mm
        ):
            return character
    return None
