"""What may lie on the table: flat things, which are printed on it, and solid ones.

Rule: named here, placed here; a room lists names.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from halo_service.virtual.bodies import Body, cup
from halo_service.virtual.pictures import MARKERS


@dataclass(frozen=True, slots=True, eq=False)
class Flat:
    """A sheet: too thin to be seen in depth, but it reflects otherwise."""

    x_mm: float
    y_mm: float
    """Its middle."""
    width_mm: float
    height_mm: float
    turn_deg: float
    print: NDArray[np.float32]
    """(h, w) reflectance, infrared and colour alike (toner is black in both), 0 to 1."""
    halo: float
    """Of the dent on plain paper."""


def sheet() -> Flat:
    """An A6 sheet of paper at the right edge of the area."""
    return Flat(255.0, 60.0, 105.0, 148.0, 8.0, np.full((4, 4), 0.8, np.float32), 1.0)


def board() -> Flat:
    """A printed marker board at the far left: four ArUco markers (4x4, numbers 40 to 43)."""
    dictionary = cv2.aruco.getPredefinedDictionary(MARKERS)
    image = np.full((200, 200), 255, np.uint8)
    for number in range(4):
        x, y = 12 + 98 * (number % 2), 12 + 98 * (number // 2)
        image[y : y + 78, x : x + 78] = cv2.aruco.generateImageMarker(dictionary, 40 + number, 78)
    return Flat(-5.0, 30.0, 80.0, 80.0, -4.0, image.astype(np.float32) / 255.0 * 0.72 + 0.06, 1.0)


FLAT: dict[str, Callable[[], Flat]] = {"sheet": sheet, "board": board}
SOLID: dict[str, Callable[[], Body]] = {"cup": lambda: cup(285.0, -5.0)}
PROPS = (*FLAT, *SOLID)
