"""From frames to strokes.

Rule: pure. A touch on the palette chooses; any other touch paints until it ends. The picture is the
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
"""Number of undo steps."""
LEAST = 0.03
"""A finger that lifts off still touches for a moment, at the protocol's least pressure (0.02)."""
HELD_BACK = 3
"""Number of points at the smallest pressure that wait, and are dropped if the touch ends:
otherwise each stroke ends in a hook, because the finger moves while it lifts off."""


class Change(Enum):
    """A change of the picture."""

    GREW = auto()
    ENDED = auto()
    UNDONE = auto()
    CLEARED = auto()
    SAVE = auto()


News = tuple[Change, Stroke | None]


@dataclass(slots=True)
class Painter:
    """Finished strokes, open strokes, and the chosen brush and colour."""

    brush: Brush = BRUSHES[0]
    colour: Colour = COLOURS[1]
    vary: bool = False
    """Whether each stroke uses the next colour and brush."""
    size_mm: tuple[float, float] = (WIDTH_MM, HEIGHT_MM)
    strokes: list[Stroke] = field(default_factory=list)
    """Finished strokes, from bottom to top."""
    _open: dict[TouchKey, Stroke] = field(default_factory=dict)
    _leaving: dict[TouchKey, deque[Moved]] = field(default_factory=dict)
    _chosen: set[TouchKey] = field(default_factory=set)
    _history: list[list[Stroke]] = field(default_factory=list)
    _begun: int = 0

    def process(self, frame: TouchFrame) -> list[News]:
        """Return the changes of a frame, in order."""
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
        """Undo the last stroke or the last clear."""
        if not self._history:
            return []
        self.strokes = self._history.pop()
        return [(Change.UNDONE, None)]

    def clear(self) -> list[News]:
        """Remove all strokes; undo restores them."""
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
            self._open[touch.key] = self._stroke()  # The touch began before this client started.
        stroke = self._open[touch.key]
        waiting = self._leaving.setdefault(touch.key, deque())
        waiting.append(touch)
        while waiting and (touch.pointer.pressure > LEAST or len(waiting) > HELD_BACK):
            held = waiting.popleft()
            x, y = held.pointer.x_mm, held.pointer.y_mm
            stroke.add(x, y, held.pointer.pressure, held.time_us)
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
            # The step 3 and the 8 colours have no common divisor, so all colours appear.
            self.colour = COLOURS[(3 * self._begun) % len(COLOURS)]
            self.brush = BRUSHES[(self._begun - 1) % len(BRUSHES)]
        return Stroke(self.brush, self.colour, self._begun)

    def _remember(self, strokes: list[Stroke]) -> None:
        self._history = [*self._history[1 - MOST_STEPS :], self.strokes]
        self.strokes = strokes
