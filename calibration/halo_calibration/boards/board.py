"""What is printed or projected to be found again: where its points are, and what they look like.

Rule: one description draws a board and finds it. Printed boards are in mm around their middle,
x to the right and y down as one reads them; projected ones in the projector's pixels, (0, 0) at
the outer corner of the top left one.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import cv2
import numpy as np
from numpy.typing import NDArray

from halo_service.errors import UserError
from halo_service.geometry.camera import Points

Picture = NDArray[np.uint8]


@dataclass(frozen=True, slots=True)
class Family:
    """A kind of marker, as the world names it."""

    name: str
    dictionary: int
    """OpenCV's number for it."""
    modules: int
    """Black and white squares along a side, the black border included."""
    turned: bool = False
    """OpenCV 4 has the AprilTags upside down. Ours stand as their makers publish them, for headsets
    that see the same tag find its corners in that order."""


ARUCO = Family("aruco-4x4", cv2.aruco.DICT_4X4_100, 6)
APRILTAG = Family("apriltag-36h11", cv2.aruco.DICT_APRILTAG_36h11, 8, turned=True)
FAMILIES = {family.name: family for family in (ARUCO, APRILTAG)}
"""4x4: the largest squares for its size, so it is read from farthest. 36h11: what robots and
headsets read."""

SQUARE = np.array([[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]])
"""A marker's corners from its middle, from the top left clockwise."""


@dataclass(frozen=True, slots=True, eq=False)
class Printed:
    """Markers of one size on one sheet."""

    name: str
    """As one calls it in a sentence."""
    family: Family
    size_mm: float
    """Of each marker, over its black."""
    middles_mm: Mapping[int, tuple[float, float]]
    """Where each marker's middle is, by its number."""

    def corners(self, marker: int) -> Points:
        """(4, 2) mm of one marker, from the top left clockwise as one reads the sheet."""
        return np.asarray(SQUARE * self.size_mm + self.middles_mm[marker], dtype=np.float64)

    def picture(self, width_mm: float, height_mm: float, per_mm: int) -> Picture:
        """(h, w) a sheet of a size with the board in its middle, so many pixels a mm."""
        picture = np.full((round(height_mm * per_mm), round(width_mm * per_mm)), 255, np.uint8)
        side = round(self.size_mm * per_mm)
        for marker, (x, y) in self.middles_mm.items():
            squares = np.where(marker_squares(self.family, marker), 0, 255).astype(np.uint8)
            black = cv2.resize(squares, (side, side), interpolation=cv2.INTER_NEAREST)
            left = round((x + width_mm / 2.0) * per_mm - side / 2.0)
            top = round((y + height_mm / 2.0) * per_mm - side / 2.0)
            picture[top : top + side, left : left + side] = black
        return picture


def _grid(first: int, columns: int, rows: int, step: float) -> dict[int, tuple[float, float]]:
    return {
        first + row * columns + column: (
            step * (column - (columns - 1) / 2.0),
            step * (row - (rows - 1) / 2.0),
        )
        for row in range(rows)
        for column in range(columns)
    }


SHEET = Printed("surface sheet", ARUCO, 45.0, _grid(50, 4, 3, 62.0))
"""Twelve markers for the middle of A4 and of Letter, both in landscape. 45 mm are 27 px of the
colour picture from 1 m, so that each of the six squares along a side is 4 px wide. The numbers 50
to 61 are in no projected board."""


def anchor(family: str, marker: int, size_mm: float) -> Printed:
    """Describe a single marker. Raises `UserError` for one that does not exist."""
    if family not in FAMILIES:
        raise UserError(f"there are no markers called {family!r}; known: {', '.join(FAMILIES)}")
    known = FAMILIES[family]
    count = len(cv2.aruco.getPredefinedDictionary(known.dictionary).bytesList)
    if not 0 <= marker < count:
        raise UserError(f"{family} has the markers 0 to {count - 1}, and no {marker}")
    if not 10.0 <= size_mm <= 1000.0:
        raise UserError(f"a marker of {size_mm:g} mm cannot be used; give 10 to 1000 mm")
    return Printed(f"printed marker {marker}", known, size_mm, {marker: (0.0, 0.0)})


ANCHOR = anchor("apriltag-36h11", 0, 80.0)
"""The anchor that the printable sheet shows."""


def marker_squares(family: Family, marker: int) -> NDArray[np.bool_]:
    """(modules, modules) of a marker as one reads it; True is black."""
    dictionary = cv2.aruco.getPredefinedDictionary(family.dictionary)
    drawn = cv2.aruco.generateImageMarker(dictionary, marker, family.modules)
    return np.asarray(np.rot90(drawn, 2) if family.turned else drawn) < 128


@dataclass(frozen=True, eq=False)
class Projected:
    """A ChArUco board that fills a projector's picture, ten squares along its longer side."""

    width_px: int
    height_px: int

    name = "projected board"
    family = ARUCO
    ALONG = 10
    """45 points on 16:10; its markers are still read where the picture is 45 cm wide and the
    camera 1 m away."""
    SHARE = 0.7
    """Marker over square: what is left around a marker keeps the squares' corners clear of it."""

    def __post_init__(self) -> None:
        """Raise `UserError` for a picture that no projector has."""
        short, long = sorted((self.width_px, self.height_px))
        if not (240 <= short <= long <= min(8192, 3 * short)):
            raise UserError(
                f"a projector's picture of {self.width_px} x {self.height_px} pixels cannot be "
                f"used; its sides may be 240 to 8192 px long, and the one three times the other"
            )

    @property
    def square_px(self) -> int:
        """Side of a square."""
        return max(self.width_px, self.height_px) // self.ALONG

    @cached_property
    def grid(self) -> cv2.aruco.CharucoBoard:
        """OpenCV's description of the board, in squares."""
        dictionary = cv2.aruco.getPredefinedDictionary(self.family.dictionary)
        columns, rows = self.width_px // self.square_px, self.height_px // self.square_px
        return cv2.aruco.CharucoBoard((columns, rows), 1.0, self.SHARE, dictionary)

    @cached_property
    def points_px(self) -> Points:
        """(N, 2) where the squares' corners are in the picture, by their number."""
        inner = np.asarray(self.grid.getChessboardCorners(), dtype=np.float64)[:, :2]
        return np.asarray(inner * self.square_px + self._corner(), dtype=np.float64)

    def picture(self) -> Picture:
        """(height, width) what the projector shall show."""
        size = tuple(count * self.square_px for count in self.grid.getChessboardSize())
        drawn = self.grid.generateImage((size[0], size[1]), marginSize=0, borderBits=1)
        picture = np.full((self.height_px, self.width_px), 255, np.uint8)
        left, top = self._corner()
        picture[top : top + size[1], left : left + size[0]] = drawn
        return picture

    def _corner(self) -> tuple[int, int]:
        columns, rows = self.grid.getChessboardSize()
        return (
            (self.width_px - columns * self.square_px) // 2,
            (self.height_px - rows * self.square_px) // 2,
        )


Board = Printed | Projected


def crosses(width_px: int, height_px: int) -> Points:
    """(9, 2) the nine projected places to touch, row by row, in the projector's pixels.

    A fifth of the picture from its edges: what is farther out may lie beyond the surface.
    """
    across, down = np.meshgrid([0.2, 0.5, 0.8], [0.2, 0.5, 0.8])
    shares = np.column_stack([across.ravel(), down.ravel()])
    return np.asarray(shares * (width_px, height_px), dtype=np.float64)
