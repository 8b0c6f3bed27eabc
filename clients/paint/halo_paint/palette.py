"""The palette: colours at the left edge of the surface, brushes and actions at the right.

Rule: values only: the area of each cell in u and v, and its meaning.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

from halo_paint.brushes import BRUSHES, COLOURS, Brush, Colour

STRIP = 0.065
"""Width of each strip relative to the surface: about a finger."""


class Action(Enum):
    """The commands of the palette."""

    UNDO = "undo"
    CLEAR = "clear"
    SAVE = "save"


@dataclass(frozen=True, slots=True)
class Cell:
    """A button of the palette."""

    area: tuple[float, float, float, float]
    """Left, far, right and near edge over the surface's width and height."""
    means: Colour | Brush | Action


def _column(left: float, right: float, meanings: tuple[Colour | Brush | Action, ...]) -> list[Cell]:
    count = len(meanings)
    return [
        Cell((left, n / count, right, (n + 1) / count), means) for n, means in enumerate(meanings)
    ]


CELLS = (
    *_column(0.0, STRIP, COLOURS),
    *_column(1.0 - STRIP, 1.0, (*BRUSHES, Action.UNDO, Action.CLEAR, Action.SAVE)),
)


def cell_at(u: float, v: float) -> Cell | None:
    """Return the cell at (u, v) or None; cells extend beyond the surface's edges."""
    if STRIP < u < 1.0 - STRIP:
        return None
    column = [cell for cell in CELLS if (cell.area[0] < 0.5) == (u < 0.5)]
    return column[min(max(int(v * len(column)), 0), len(column) - 1)]
