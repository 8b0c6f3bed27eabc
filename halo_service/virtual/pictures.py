"""What the projector shows: a name or a file becomes a picture for each moment.

Rule: (height, width, 3) uint8 BGR at the projector's resolution, a function of time alone.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from halo_service.errors import UserError

Picture = NDArray[np.uint8]
Show = Callable[[float], Picture]
"""Seconds since the start -> picture."""

MARKERS = cv2.aruco.DICT_4X4_50
MOVIE_FPS = 30.0


def still(picture: Picture) -> Show:
    """One picture for ever."""
    return lambda _: picture


def colours(width: int, height: int) -> Show:
    """Saturated stripes that wander and change: what breaks hand trackers that see colour only."""
    rows, columns = np.mgrid[:height:8, :width:8].astype(np.float32)

    def show(t_s: float) -> Picture:
        hue = (columns * 0.25 + rows * 0.1 + 45.0 * t_s) % 180.0
        value = 150.0 + 100.0 * np.sin(rows / 60.0 + 1.3 * t_s)
        small = cv2.merge([hue, np.full_like(hue, 230.0), value]).astype(np.uint8)
        return _sized(cv2.cvtColor(small, cv2.COLOR_HSV2BGR), width, height)

    return show


def checker(width: int, height: int) -> Show:
    """Black and white squares of 80 pixels, standing still."""
    rows, columns = np.mgrid[:height, :width]
    board = (((rows // 80) + (columns // 80)) % 2 * 255).astype(np.uint8)
    still = np.repeat(board[..., None], 3, axis=2)
    return lambda _: still


def markers(width: int, height: int) -> Show:
    """Eight ArUco markers (4x4, numbers 0 to 7) on white, as projector calibrations show them."""
    image = np.full((height, width), 255, np.uint8)
    side = height // 4
    dictionary = cv2.aruco.getPredefinedDictionary(MARKERS)
    for number in range(8):
        column, row = number % 4, number // 4
        x = width * (2 * column + 1) // 8 - side // 2
        y = height * (2 * row + 1) // 4 - side // 2
        image[y : y + side, x : x + side] = cv2.aruco.generateImageMarker(dictionary, number, side)
    still = np.repeat(image[..., None], 3, axis=2)
    return lambda _: still


def dark(width: int, height: int) -> Show:
    """Nothing but the projector's black."""
    still = np.zeros((height, width, 3), np.uint8)
    return lambda _: still


PICTURES: dict[str, Callable[[int, int], Show]] = {
    "dark": dark,
    "colours": colours,
    "checker": checker,
    "markers": markers,
}


def findable(name: str) -> str:
    """The name, when there is such a picture. Raises UserError otherwise."""
    if name not in PICTURES and not Path(name).is_file():
        raise UserError(
            f"The virtual projector finds no picture {name!r}; "
            f"give a file, or one of {', '.join(PICTURES)}."
        )
    return name


def show(name: str, width: int, height: int) -> Show:
    """Find a picture by its name in PICTURES, or load an image or a video from a file.

    Raises UserError where there is neither.
    """
    if name in PICTURES:
        return PICTURES[name](width, height)
    image = cv2.imread(findable(name), cv2.IMREAD_COLOR)
    if image is not None:
        still = _sized(image, width, height)
        return lambda _: still
    return _movie(name, width, height)


def _movie(name: str, width: int, height: int) -> Show:
    """At most ten seconds of a video, over and over; stored at a quarter of the size each way."""
    film = cv2.VideoCapture(name)
    frames: list[Picture] = []
    while len(frames) < 10 * MOVIE_FPS:
        going, image = film.read()
        if not going:
            break
        frames.append(_sized(image, width // 4, height // 4))
    film.release()
    if not frames:
        raise UserError(f"The virtual projector cannot read {name!r}; give an image or a video.")
    return lambda t_s: _sized(frames[int(t_s * MOVIE_FPS) % len(frames)], width, height)


def _sized(image: cv2.typing.MatLike, width: int, height: int) -> Picture:
    resized = cv2.resize(image, (width, height), interpolation=cv2.INTER_LINEAR)
    return np.asarray(resized, dtype=np.uint8)
