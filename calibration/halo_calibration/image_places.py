"""Places in the camera's picture, in a person's words. The picture's top is the far edge."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

_ROWS = ("far", "", "near")
_COLUMNS = ("left", "", "right")


def place(x_share: float, y_share: float, rows: tuple[str, str, str] = _ROWS) -> str:
    """Name a ninth of a picture; shares run from 0 (left, far) to 1 (right, near)."""
    row = rows[min(int(3.0 * y_share), 2)]
    column = _COLUMNS[min(int(3.0 * x_share), 2)]
    if row and not column:
        return f"at the {row} edge"
    words = " ".join(word for word in (row, column) if word)
    return f"at the {words}" if words else "in the middle"


def largest(mask: NDArray[np.bool_]) -> tuple[int, str]:
    """Return size and place of a mask's largest connected region; (0, "") where there is none."""
    count, _, stats, centres = cv2.connectedComponentsWithStats(mask.astype(np.uint8))
    if count < 2:
        return 0, ""
    biggest = 1 + int(np.argmax(stats[1:, cv2.CC_STAT_AREA]))
    height, width = mask.shape
    x, y = centres[biggest]
    return int(stats[biggest, cv2.CC_STAT_AREA]), place((x + 0.5) / width, (y + 0.5) / height)
