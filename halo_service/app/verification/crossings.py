"""A grid on the table, and the distance of touches from its crossings. Pure.

Rule: positions are mm on the surface; projector pixels have (0, 0) at the outer corner of the top
left pixel.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

Places = NDArray[np.float64]
Picture = NDArray[np.uint8]

STEP_MM = 50.0
"""About the distance between crossings; chosen."""
EDGE_MM = 30.0
"""From the edge of the surface to the outer crossings, so that the hand stays in view."""
REACH_MM = 20.0
"""A touch farther than this from every crossing is not counted; less than half a step."""
SHIFT = 4
"""Fractional bits of OpenCV's drawing coordinates, for lines at exact positions."""
EDGE, GRID, DOT, NEXT, TEXT = (
    (90, 60, 30),
    (90, 90, 90),
    (80, 220, 80),
    (60, 200, 255),
    (230, 230, 230),
)
"""Blue, green, red. Dim lines: projected light lies on the finger too."""


@dataclass(frozen=True, slots=True)
class Landing:
    """One touch near a crossing."""

    crossing: int
    dx_mm: float
    """Positive: to the right of the crossing."""
    dy_mm: float
    """Positive: nearer to the user."""

    @property
    def off_mm(self) -> float:
        """Distance from the crossing."""
        return float(np.hypot(self.dx_mm, self.dy_mm))


@dataclass(frozen=True, slots=True)
class Summary:
    """All touches of a verification."""

    touches: int
    crossings: int
    """Touched at least once."""
    median_mm: float
    p95_mm: float
    worst: int
    """The crossing with the largest median error."""
    worst_mm: float


class Grid:
    """Crossings over a surface, and the touches on them."""

    def __init__(
        self,
        width_mm: float,
        height_mm: float,
        picture_from_surface: Places,
        size_px: tuple[int, int],
    ) -> None:
        """`picture_from_surface`: (3, 3) homography, mm -> px of a picture of `size_px`; crossings
        outside that picture are left out."""
        self._matrix, self._size_px = picture_from_surface, size_px
        self._corners = np.array([[0, 0], [1, 0], [1, 1], [0, 1]]) * (width_mm, height_mm)
        self._xs, self._ys = _spread(width_mm), _spread(height_mm)
        x, y = np.meshgrid(self._xs, self._ys)
        every = np.column_stack([x.ravel(), y.ravel()])
        px = _pixels(picture_from_surface, every)
        self.places: Places = every[((px >= 0.0) & (px < size_px)).all(axis=1)]
        """(N, 2), row by row from the far left."""
        self.landings: list[Landing] = []
        self.given_up: set[int] = set()
        """Crossings that the user need not touch any more."""

    def land(self, x_mm: float, y_mm: float) -> Landing | None:
        """Count a touch for the nearest crossing; None if none is near."""
        away = self.places - (x_mm, y_mm)
        nearest = int(np.argmin(np.hypot(*away.T)))
        landing = Landing(nearest, *(-float(part) for part in away[nearest]))
        if landing.off_mm > REACH_MM:
            return None
        self.landings.append(landing)
        return landing

    @property
    def next(self) -> int | None:
        """The first crossing that is not touched yet; None when all are."""
        done = {landing.crossing for landing in self.landings} | self.given_up
        return next((n for n in range(len(self.places)) if n not in done), None)

    def summary(self) -> Summary | None:
        """Return the figures; None before the first touch."""
        if not self.landings:
            return None
        off: dict[int, list[float]] = {}
        for landing in self.landings:
            off.setdefault(landing.crossing, []).append(landing.off_mm)
        worst = max(off, key=lambda crossing: float(np.median(off[crossing])))
        every = [landing.off_mm for landing in self.landings]
        return Summary(
            len(every),
            len(off),
            float(np.median(every)),
            float(np.percentile(every, 95)),
            worst,
            float(np.median(off[worst])),
        )

    def name(self, crossing: int) -> str:
        """Return where a crossing is, in words and mm."""
        x, y = self.places[crossing]
        row, column = np.argmin(np.abs(self._ys - y)), np.argmin(np.abs(self._xs - x))
        return f"row {row + 1} from the far edge, column {column + 1} ({x:.0f}, {y:.0f} mm)"

    def pixel(self, crossing: int) -> tuple[float, float]:
        """Return the position of a crossing in the picture, px."""
        x, y = _pixels(self._matrix, self.places[crossing][None])[0]
        return float(x), float(y)

    def off_px(self, landing: Landing) -> float:
        """Return how far a touch is from its crossing in the picture, px."""
        place = self.places[landing.crossing]
        touched = place + np.array([landing.dx_mm, landing.dy_mm])
        aim, hit = _pixels(self._matrix, np.array([place, touched]))
        return float(np.hypot(*(hit - aim)))

    def picture(self, fingers: Sequence[Finger]) -> Picture:
        """Draw the edge of the surface, the grid, a dot under each finger and the touches; (height,
        width, 3) BGR."""
        picture_from_surface = self._matrix
        canvas = np.zeros((self._size_px[1], self._size_px[0], 3), np.uint8)
        outline = np.array([_fine(px) for px in _pixels(picture_from_surface, self._corners)])
        cv2.polylines(canvas, [outline], True, EDGE, 2, cv2.LINE_AA, SHIFT)
        for start, end in self._lines():
            a, b = _pixels(picture_from_surface, np.array([start, end]))
            cv2.line(canvas, _fine(a), _fine(b), GRID, 2, cv2.LINE_AA, SHIFT)
        per_mm = _scale(picture_from_surface, self.places.mean(axis=0))
        if self.next is not None:
            _ring(canvas, np.array(self.pixel(self.next)), 8.0 * per_mm, NEXT)
        for crossing, landing in {each.crossing: each for each in self.landings}.items():
            at = self.places[crossing] + (3.0, -3.0)  # next to the crossing, off its lines
            text = f"{landing.off_mm:.1f}"
            x, y = _pixels(picture_from_surface, at[None])[0]
            where = (round(x), round(y))
            cv2.putText(canvas, text, where, cv2.FONT_HERSHEY_SIMPLEX, 0.2 * per_mm, TEXT, 1, 16)
        for finger in fingers:
            middle = _pixels(picture_from_surface, np.array([(finger.x_mm, finger.y_mm)]))[0]
            _ring(canvas, middle, (3.0 if finger.touching else 6.0) * per_mm, DOT)
        return canvas

    def _lines(self) -> list[tuple[tuple[float, float], tuple[float, float]]]:
        xs, ys = self._xs.tolist(), self._ys.tolist()
        down = [((x, ys[0]), (x, ys[-1])) for x in xs]
        return down + [((xs[0], y), (xs[-1], y)) for y in ys]


@dataclass(frozen=True, slots=True)
class Finger:
    """A finger to draw, mm on the surface."""

    x_mm: float
    y_mm: float
    touching: bool


def _spread(length_mm: float) -> Places:
    edge = min(EDGE_MM, length_mm / 4.0)
    count = max(round((length_mm - 2.0 * edge) / STEP_MM), 1) + 1
    return np.linspace(edge, length_mm - edge, count)


def _pixels(picture_from_surface: Places, places: Places) -> Places:
    """Return pixels (N, 2) of places (N, 2)."""
    image = np.column_stack([places, np.ones(len(places))]) @ picture_from_surface.T
    return np.asarray(image[:, :2] / image[:, 2:], dtype=np.float64)


def _scale(picture_from_surface: Places, at: Places) -> float:
    """Return the pixels per mm around a place."""
    here, right, down = _pixels(picture_from_surface, at + np.array([[0, 0], [1, 0], [0, 1]]))
    (a, b), (c, d) = right - here, down - here
    return float(np.sqrt(abs(a * d - b * c)))


def _fine(px: Places) -> tuple[int, int]:
    """Return a pixel in sixteenths for OpenCV; its (0, 0) is the centre of a pixel."""
    x, y = np.rint((np.clip(px, -9999.0, 9999.0) - 0.5) * (1 << SHIFT)).astype(int)
    return int(x), int(y)


def _ring(canvas: Picture, middle: Places, radius_px: float, colour: tuple[int, int, int]) -> None:
    radius = max(1, round(radius_px * (1 << SHIFT)))
    cv2.circle(canvas, _fine(middle), radius, colour, 2, cv2.LINE_AA, SHIFT)
