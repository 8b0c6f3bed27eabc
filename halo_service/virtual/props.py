"""What may lie on the table: flat things, which are printed on it, and solid ones.

Rule: what a room lists by name is placed here; a sheet with a picture of the user's own is laid
where the user says.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from halo_service.errors import UserError
from halo_service.virtual.bodies import Body, cup
from halo_service.virtual.mesh import Floats
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
    halo: float = 1.0
    """Of the dent on plain paper."""


FINE = 400
"""Vertices across a standing card, at most. A vertex is what can have a colour of its own: so many
make the edges of a card of 100 mm sharper than a colour pixel at 0.5 m, which is 0.8 mm."""
SOFT_MM = 0.3
"""How soft a card's edges are, one sigma: a pixel of the colour lens averages over 0.8 mm."""
PAPER, TONER = 0.78, 0.06
"""Reflectance of white paper and of black toner, in colour and near infrared alike; chosen."""


def printed(
    picture: NDArray[np.uint8], x_mm: float, y_mm: float, width_mm: float, turn_deg: float = 0.0
) -> Flat:
    """A sheet of paper with a picture on it that fills it: (h, w) or (h, w, 3), BGR.

    `x_mm`, `y_mm`: its middle; `turn_deg`: positive turns its right side towards the user. The
    picture's pixels are square, so its width gives its height.
    """
    grey = picture if picture.ndim == 2 else cv2.cvtColor(picture, cv2.COLOR_BGR2GRAY)
    height_mm = width_mm * grey.shape[0] / grey.shape[1]
    reflects = TONER + (PAPER - TONER) * grey.astype(np.float32) / np.float32(255.0)
    return Flat(x_mm, y_mm, width_mm, height_mm, turn_deg, reflects.astype(np.float32))


def sheets(text: str) -> tuple[Flat, ...]:
    """Read `FILE@x,y,width[,turn]` (mm and degrees, of the middle), several parted by `;`.

    Raises UserError.
    """
    return tuple(_sheet(part) for part in text.split(";") if part)


def _sheet(text: str) -> Flat:
    path, _, where = text.rpartition("@")
    picture = cv2.imread(path, cv2.IMREAD_GRAYSCALE) if Path(path).is_file() else None
    if picture is None:
        raise UserError(f"The virtual sheet finds no picture {path!r}; give FILE@x,y,width.")
    try:
        x_mm, y_mm, width_mm, turn_deg = (float(n) for n in (where + ",0").split(",")[:4])
    except ValueError:
        raise UserError(
            f"The virtual sheet lies at {where!r}; give its middle and its width in mm, and its "
            f"turn in degrees where it has one: FILE@150,100,210,10."
        ) from None
    return printed(np.asarray(picture, np.uint8), x_mm, y_mm, width_mm, turn_deg)


def standing(picture: NDArray[np.uint8], width_mm: float, surface_from_sheet: Floats) -> Body:
    """A stiff card with a picture on it, anywhere: (h, w) or (h, w, 3), BGR.

    `surface_from_sheet`: (4, 4), mm; the sheet's frame has its origin in the middle, x to its
    right, y to its bottom, z into it.
    """
    flat = printed(picture, 0.0, 0.0, width_mm)
    columns = min(flat.print.shape[1], FINE)
    rows = round(columns * flat.height_mm / flat.width_mm)
    fine = cv2.resize(flat.print, (columns, rows), interpolation=cv2.INTER_AREA)
    fine = cv2.GaussianBlur(fine, (0, 0), SOFT_MM * columns / width_mm)
    row, column = np.mgrid[:rows, :columns]
    x = ((column + 0.5) / columns - 0.5) * flat.width_mm
    y = ((row + 0.5) / rows - 0.5) * flat.height_mm
    points = np.stack([x, y, np.zeros_like(x)], axis=-1).reshape(-1, 3)
    turn = surface_from_sheet[:3, :3]
    number = np.arange(rows * columns).reshape(rows, columns)
    a, b, c, d = (
        corner.ravel()
        for corner in (number[:-1, :-1], number[:-1, 1:], number[1:, 1:], number[1:, :-1])
    )
    faces = np.concatenate([np.column_stack([a, c, b]), np.column_stack([a, d, c])])
    shade = np.ascontiguousarray(fine.reshape(-1), dtype=np.float32)
    return Body(
        points @ turn.T + surface_from_sheet[:3, 3],
        np.tile(-turn[:, 2], (len(points), 1)),
        faces,
        shade,
        np.repeat(shade[:, None], 3, axis=1),
    )


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
