"""The layouts: one table of where which note is, and what x, y and height do.

Rule: values and pure functions. A pitch is a MIDI note number, 60 is C4; 60.5 is a quarter tone
above.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

NAMES = ("C", "C#", "D", "D#", "E", "F", "F#", "G", "G#", "A", "A#", "B")
FLATS = {"Db": "C#", "Eb": "D#", "Gb": "F#", "Ab": "G#", "Bb": "A#"}

# fmt: off
SCALES: dict[str, tuple[int, ...]] = {
    "major":      (0, 2, 4, 5, 7, 9, 11),
    "minor":      (0, 2, 3, 5, 7, 8, 10),
    "pentatonic": (0, 3, 5, 7, 10),
    "blues":      (0, 3, 5, 6, 7, 10),
    "dorian":     (0, 2, 3, 5, 7, 9, 10),
    "whole-tone": (0, 2, 4, 6, 8, 10),
}
# fmt: on
"""Semitones of each scale above its root."""
WHITE = SCALES["major"]
GRID_COLUMNS, GRID_ROWS, FOURTH = 8, 5, 5
OCTAVES = 2
"""Of the keyboard strip and of the scale."""
BLACK_DEPTH, BLACK_WIDTH = 0.6, 0.6
"""Of a black key: over the strip's height, and over a white key's width."""
DRUM_COLUMNS, DRUM_ROWS, DRUM_ROOT = 4, 4, 36
"""Pads as on drum machines: 36 (kick) at the lower left, 51 at the upper right."""


@dataclass(frozen=True, slots=True)
class Key:
    """An area with one note."""

    area: tuple[float, float, float, float]
    """Left, far, right and near edge over the surface's width and height, 0 to 1."""
    note: int

    def slide(self, v: float) -> float:
        """Return 0 at the near edge to 1 at the far edge."""
        _, far, _, near = self.area
        return min(max((near - v) / (near - far), 0.0), 1.0)


@dataclass(frozen=True, slots=True)
class Layout:
    """A row of the table, with its keys."""

    name: str
    notes: str
    """For the help: which note is where."""
    moves: str
    """For the help: what a movement to the side does."""
    root: int
    """Lowest note, unless the user chooses one."""
    keys: Callable[[int, tuple[int, ...]], tuple[Key, ...]]
    """Root and scale to keys; the first key that has a place counts."""
    semitones: float
    """Pitch bend over the whole width of the surface."""
    continuous: bool = False
    """Whether a note starts at the exact pitch of its place, not at that of its key."""
    in_air: bool = False
    """Whether the index finger sounds above the surface; else only touches do."""


def grid(root: int, scale: tuple[int, ...]) -> tuple[Key, ...]:
    """Semitones to the right, fourths away from the player."""
    return tuple(
        Key(_cell(column, row, GRID_COLUMNS, GRID_ROWS), root + column + FOURTH * row)
        for row in range(GRID_ROWS)
        for column in range(GRID_COLUMNS)
    )


def keyboard(root: int, scale: tuple[int, ...]) -> tuple[Key, ...]:
    """Piano keys; black keys first, for they lie over the white ones."""
    whites = [root + 12 * octave + step for octave in range(OCTAVES) for step in WHITE]
    width = 1.0 / len(whites)
    white = [Key((n * width, 0.0, (n + 1) * width, 1.0), note) for n, note in enumerate(whites)]
    half = BLACK_WIDTH * width / 2
    black = [
        Key(((n + 1) * width - half, 0.0, (n + 1) * width + half, BLACK_DEPTH), note + 1)
        for n, note in enumerate(whites[:-1])
        if whites[n + 1] - note == 2
    ]
    return (*black, *white)


def strips(root: int, scale: tuple[int, ...]) -> tuple[Key, ...]:
    """A strip for each note of the scale, over two octaves."""
    notes = [root + 12 * octave + step for octave in range(OCTAVES) for step in scale]
    notes.append(root + 12 * OCTAVES)
    return tuple(Key(_cell(n, 0, len(notes), 1), note) for n, note in enumerate(notes))


def drum_pads(root: int, scale: tuple[int, ...]) -> tuple[Key, ...]:
    """Four by four, in the order of drum machines."""
    return tuple(
        Key(_cell(column, row, DRUM_COLUMNS, DRUM_ROWS), root + column + DRUM_COLUMNS * row)
        for row in range(DRUM_ROWS)
        for column in range(DRUM_COLUMNS)
    )


def whole(root: int, scale: tuple[int, ...]) -> tuple[Key, ...]:
    """The surface as one key."""
    return (Key((0.0, 0.0, 1.0, 1.0), root),)


# fmt: off
LAYOUTS = {row.name: row for row in (
    Layout("grid", "8 x 5 pads, semitones to the right, fourths away from you",
           "bends the pitch, a pad is a semitone", 48, grid, GRID_COLUMNS),
    Layout("keys", "piano keys of two octaves",
           "bends the pitch, two octaves over the table", 48, keyboard, 12 * OCTAVES),
    Layout("scale", "a strip for each note of --scale, two octaves",
           "bends the pitch, two octaves over the table", 48, strips, 12 * OCTAVES),
    Layout("drums", "4 x 4 pads as on drum machines, from note 36",
           "does nothing", DRUM_ROOT, drum_pads, 0.0),
    Layout("ribbon", "any pitch, three octaves from left to right",
           "glides", 48, whole, 36.0, continuous=True),
    Layout("theremin", "any pitch in the air: the index finger sounds, louder when it is lower",
           "glides", 48, whole, 36.0, continuous=True, in_air=True),
)}
# fmt: on


@dataclass(frozen=True, slots=True)
class Board:
    """A layout with its keys computed."""

    layout: Layout
    root: int
    keys: tuple[Key, ...]

    def key(self, u: float, v: float) -> Key:
        """Return the key at a place; outside the surface, the nearest one."""
        x, y = min(max(u, 0.0), 1.0), min(max(v, 0.0), 1.0)
        return next(key for key in self.keys if _inside(key.area, x, y))

    def pitch(self, u: float, v: float) -> float:
        """Return the pitch of a note that starts at a place."""
        if self.layout.continuous:
            return self.root + self.layout.semitones * min(max(u, 0.0), 1.0)
        return float(self.key(u, v).note)


def board(name: str, root: int | None = None, scale: str = "major") -> Board:
    """Compute a layout. `KeyError` for an unknown name."""
    layout = LAYOUTS[name]
    lowest = layout.root if root is None else root
    return Board(layout, lowest, layout.keys(lowest, SCALES[scale]))


def note_number(name: str) -> int:
    """Read a note such as C3, F#2, Bb4 or 60. `ValueError` for anything else."""
    if name.isdigit():
        number = int(name)
    else:
        letters = name.rstrip("-0123456789")
        key = letters[:1].upper() + letters[1:]
        number = NAMES.index(FLATS.get(key, key)) + 12 * (int(name[len(letters) :]) + 1)
    if not 0 <= number <= 127:
        raise ValueError(f"{name} is outside MIDI's notes")
    return number


def note_name(number: int) -> str:
    """Write a note, such as C4 for 60."""
    return f"{NAMES[number % 12]}{number // 12 - 1}"


def _cell(column: int, row: int, columns: int, rows: int) -> tuple[float, float, float, float]:
    """An area of an even grid; row 0 is nearest to the player."""
    far = (rows - 1 - row) / rows
    return (column / columns, far, (column + 1) / columns, far + 1 / rows)


def _inside(area: tuple[float, float, float, float], x: float, y: float) -> bool:
    left, far, right, near = area
    # Edges computed with floats can leave a gap of one rounding error.
    return left - 1e-9 <= x <= right + 1e-9 and far - 1e-9 <= y <= near + 1e-9
