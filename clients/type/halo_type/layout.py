"""A keyboard on the surface: where the keys are, and which one a touch hits.

Rule: pure geometry, in mm on the surface, origin at its top left, y towards the user. A layout is a
small TOML file in `layouts/`; the study's is `qwerty`: 16 mm squares, three rows and a space bar.
"""

from __future__ import annotations

import math
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from importlib import resources
from pathlib import Path
from typing import Any

KEY_MM = 16.0
"""Size of the study's keys."""
SPACE = " "
DELETE, DONE = "delete", "done"
"""Keys that type no character: erase the last one, and end the phrase."""
WIDE = {"space": SPACE, DELETE: DELETE, DONE: DONE}
LAYOUTS = ("qwerty", "qwertz", "azerty")
MOST_KEYS = 200
"""In a layout file; more is a mistake."""


class LayoutError(Exception):
    """A layout file cannot be used. The message is for the user."""


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


@dataclass(frozen=True, slots=True)
class Layout:
    """Keys with the keyboard's top left corner at (0, 0)."""

    keys: tuple[Key, ...]

    @property
    def width_mm(self) -> float:
        """From the left edge of the keyboard to its right edge."""
        return max(key.x_mm + key.width_mm for key in self.keys)

    @property
    def height_mm(self) -> float:
        """From its far edge to its near edge."""
        return max(key.y_mm + key.height_mm for key in self.keys)

    def placed(self, x_mm: float, y_mm: float) -> dict[str, Key]:
        """All keys by their character, the keyboard's top left corner at a place."""
        return {
            key.character: Key(
                key.character, key.x_mm + x_mm, key.y_mm + y_mm, key.width_mm, key.height_mm
            )
            for key in self.keys
        }


def parse_layout(text: str) -> Layout:
    """Read a layout file. Raises `LayoutError` with one sentence."""
    try:
        table = tomllib.loads(text)
        size = float(table.get("key_mm", KEY_MM))
        keys = [key for number, row in enumerate(table["rows"]) for key in _row(row, number, size)]
        keys += [_wide(each, size) for each in table.get("wide", ())]
    except tomllib.TOMLDecodeError as error:
        raise LayoutError(f"it is not TOML ({error})") from error
    except (KeyError, TypeError, ValueError, AttributeError) as error:
        reason = f"no {error}" if isinstance(error, KeyError) else error
        raise LayoutError(f"{reason}; compare it with layouts/qwerty.toml") from error
    _check(keys)
    return Layout(tuple(keys))


@lru_cache(maxsize=8)
def load_layout(name: str) -> Layout:
    """Return a layout by its name, or from a file. Raises `LayoutError`."""
    try:
        if name in LAYOUTS:
            text = resources.files("halo_type").joinpath(f"layouts/{name}.toml").read_text("utf-8")
        elif name.endswith(".toml"):
            text = Path(name).read_text("utf-8")
        else:
            raise LayoutError(f"choose from {', '.join(LAYOUTS)}, or give a file such as mine.toml")
        return parse_layout(text)
    except LayoutError as error:
        raise LayoutError(f"unknown or wrong layout {name!r}: {error}") from error
    except (OSError, UnicodeDecodeError) as error:
        reason = getattr(error, "strerror", None) or error
        raise LayoutError(f"cannot read {name} ({reason}); check the path") from error


def keyboard(x_mm: float, y_mm: float, layout: str = "qwerty") -> dict[str, Key]:
    """The keys that type a character, the keyboard's top left corner at a place."""
    return {
        character: key
        for character, key in load_layout(layout).placed(x_mm, y_mm).items()
        if len(character) == 1
    }


def key_at(keys: Mapping[str, Key], x_mm: float, y_mm: float) -> str | None:
    """The character of the key that a touch hits, or None outside all keys."""
    for character, key in keys.items():
        if key.x_mm <= x_mm < key.x_mm + key.width_mm and (
            key.y_mm <= y_mm < key.y_mm + key.height_mm
        ):
            return character
    return None


def _row(row: Mapping[str, Any], number: int, size: float) -> list[Key]:
    start = float(row["start"])
    return [
        Key(character.lower(), (start + column) * size, number * size, size, size)
        for column, character in enumerate(row["keys"])
    ]


def _wide(each: Mapping[str, Any], size: float) -> Key:
    start, width = float(each["start"]), float(each["width"])
    return Key(WIDE[each["key"]], start * size, int(each["row"]) * size, width * size, size)


def _check(keys: list[Key]) -> None:
    if not 1 <= len(keys) <= MOST_KEYS:
        raise LayoutError(f"it has {len(keys)} keys; 1 to {MOST_KEYS} are allowed")
    sizes = [value for key in keys for value in (key.x_mm, key.y_mm, key.width_mm, key.height_mm)]
    if not all(map(math.isfinite, sizes)) or min(sizes) < 0 or min(k.width_mm for k in keys) <= 0:
        raise LayoutError("a start, width or row is negative, or a size is 0")
    for number, key in enumerate(keys):
        for other in keys[:number]:
            if key.character == other.character:
                raise LayoutError(f"it has the key {key.character!r} twice")
            if _overlap(key, other):
                raise LayoutError(f"the keys {other.character!r} and {key.character!r} overlap")


def _overlap(a: Key, b: Key) -> bool:
    gap_x = max(a.x_mm, b.x_mm) - min(a.x_mm + a.width_mm, b.x_mm + b.width_mm)
    gap_y = max(a.y_mm, b.y_mm) - min(a.y_mm + a.height_mm, b.y_mm + b.height_mm)
    return gap_x < -1e-6 and gap_y < -1e-6
