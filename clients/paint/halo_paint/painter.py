"""From frames to a picture: what fingers mean to the paper.

Rule: pure. A touch on the palette chooses; any other paints, until it ends. The picture is the
list of strokes, and undo goes back step by step, also over a clear.
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass, field
from enum import Enum, auto

from halo_client import Began, Ended, Moved, TouchKey, touches
from halo_client.picture import HEIGHT_MM, WIDTH_MM
from halo_paint.brushes import BRUSHES, COLOURS, Brush, Colour
from halo_paint.palette import Action, Cell, cell_at
from halo_paint.stroke import Stroke
from halo_protocol import TouchFrame

MOST_STEPS = 500
"""Undo goes back so far."""
LEAST = 0.03
"""A finger that lifts off still touches for a moment, at the promise's least pressure (0.02)."""
HELD_BACK = 3
"""So many places at the least pressure wait, and are not painted if the touch ends with them:
else each stroke would end in the hook of the finger that leaves."""


class Change(Enum):
    """What became of the picture."""

    GREW = auto()
    ENDED = auto()
    UNDONE = auto()
    CLEARED = auto()
    SAVE = auto()


News = tuple[Change, Stroke | None]


@dataclass(slots=True)
class Painter:
    """The paper, what is chosen, and the strokes that are being painted."""

    brush: Brush = BRUSHES[0]
    colour: Colour = COLOURS[1]
    vary: bool = False
    """Whether each stroke takes the next colour and brush, for those who watch."""
    size_mm: tuple[float, float] = (WIDTH_MM, HEIGHT_MM)
    strokes: list[Stroke] = field(default_factory=list)
    """Finished, from the lowest to the topmost."""
    _open: dict[TouchKey, Stroke] = field(default_factory=dict)
    _leaving: dict[TouchKey, deque[Moved]] = field(default_factory=dict)
    _chosen: set[TouchKey] = field(default_factory=set)
    _history: list[list[Stroke]] = field(default_factory=list)
    _begun: int = 0

    def take(self, frame: TouchFrame) -> list[News]:
        """What a frame changes, in order."""
        news: list[News] = []
        for touch in touches(frame):
            if isinstance(touch, Began):
                news += self._begin(touch)
            elif isinstance(touch, Moved):
                news += self._move(touch)
            else:
                news += self._end(touch)
        return news

    def undo(self) -> list[News]:
        """Take back the last stroke, or the last clear."""
        if not self._history:
            return []
        self.strokes = self._history.pop()
        return [(Change.UNDONE, None)]

    def clear(self) -> list[News]:
        """An empty paper; undo brings the strokes back."""
        if not self.strokes:
            return []
        self._remember([])
        return [(Change.CLEARED, None)]

    def _begin(self, touch: Began) -> list[News]:
        cell = cell_at(touch.down.u, touch.down.v)
        if cell is not None:
            self._chosen.add(touch.key)
            return self._choose(cell)
        stroke = self._open[touch.key] = self._stroke()
        x, y = touch.down.u * self.size_mm[0], touch.down.v * self.size_mm[1]
        pressure = touch.pointer.pressure if touch.pointer else 0.0
        stroke.add(x, y, pressure, touch.time_us)
        if touch.pointer is not None:
            stroke.add(touch.pointer.x_mm, touch.pointer.y_mm, pressure, touch.time_us)
        return [(Change.GREW, stroke)]

    def _move(self, touch: Moved) -> list[News]:
        if touch.key in self._chosen:
            return []
        if touch.key not in self._open:
            self._open[touch.key] = self._stroke()  # It was down before we came.
        stroke = self._open[touch.key]
        waiting = self._leaving.setdefault(touch.key, deque())
        waiting.append(touch)
        while waiting and (touch.pointer.pressure > LEAST or len(waiting) > HELD_BACK):
            seen = waiting.popleft()
            x, y = seen.pointer.x_mm, seen.pointer.y_mm
            stroke.add(x, y, seen.pointer.pressure, seen.time_us)
        return [(Change.GREW, stroke)]

    def _end(self, touch: Ended) -> list[News]:
        self._chosen.discard(touch.key)
        self._leaving.pop(touch.key, None)
        stroke = self._open.pop(touch.key, None)
        if stroke is None:
            return []
        stroke.end()
        self._remember([*self.strokes, stroke])
        return [(Change.GREW, stroke), (Change.ENDED, stroke)]

    def _choose(self, cell: Cell) -> list[News]:
        if isinstance(cell.means, Brush):
            self.brush = cell.means
        elif cell.means is Action.UNDO:
            return self.undo()
        elif cell.means is Action.CLEAR:
            return self.clear()
        elif cell.means is Action.SAVE:
            return [(Change.SAVE, None)]
        else:
            self.colour = cell.means
        return []

    def _stroke(self) -> Stroke:
        self._begun += 1
        if self.vary:
            # A step that has no divisor in common with 8 colours: all of them come.
            self.colour = COLOURS[(3 * self._begun) % len(COLOURS)]
            self.brush = BRUSHES[(self._begun - 1) % len(BRUSHES)]
        return Stroke(self.brush, self.colour, self._begun)

    def _remember(self, strokes: list[Stroke]) -> None:
        self._history = [*self._history[1 - MOST_STEPS :], self.strokes]
        self.strokes = strokes
