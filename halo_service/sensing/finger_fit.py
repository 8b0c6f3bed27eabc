"""Where a finger is, to a few millimetres: a finger-shaped template, fitted to the mask.

A finger is a round end of known breadth with a straight part behind it, and around it is surface
or another finger. The place where this fits best is the end of the finger, also where a neighbour
touches its side and where the landmarks are off. How far the landmarks are off decides between
places that fit almost as well.
"""

from __future__ import annotations

import math
from functools import lru_cache
from typing import NamedTuple

import cv2
import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray

from halo_service.sensing.finger_frame import FingerFrame, Grid, blended, grid

Floats = NDArray[np.float32]

STEP_MM = 2.0
"""Between samples: a pixel at 0.6 m."""
ALONG_MM, ACROSS_MM = 24, 14
"""The search range for the end, to both sides of the guess: a fast finger's path in one frame."""
LENGTH_MM, BESIDE_MM = 18.0, 5.0
"""Of the template: a finger's last segment, and what must be free around it."""
TURNS_DEG = (-32.0, -16.0, 0.0, 16.0, 32.0)
"""Directions that are tried, relative to the guess."""
ERROR_ALONG_MM, ERROR_ACROSS_MM, ERROR_DEG = 6.0, 3.5, 12.0
"""Of the hand model's fingertip (measured on the virtual camera: 2 to 5 mm along a finger, 2 mm
across it, 10 degrees)."""
WEIGHT = 14.0
"""Of the fit against these errors: a fit that is worse by 0.07 is as unlikely as one error."""
LEAST_FIT = 0.4
"""Of 2: a worse fit is no finger (chosen: 1.0 to 1.4 on fingers, 0.5 where half is hidden)."""
UNKNOWN = 0.3
"""Weight of samples where nothing is known: 1 counts them as neither finger nor surface, 0 leaves
them out of the means (chosen)."""
AROUND = 3
"""Samples to each side over which the best place is averaged (chosen: half a finger)."""


class Fit(NamedTuple):
    """The best place of a finger."""

    place: FingerFrame
    quality: float
    """2: all that is inside is this finger, nothing around it is. 0: no finger."""


class _Template(NamedTuple):
    at: Grid
    """(turns * rows, columns): what is read around all places that are tried, in all turns."""
    rows: int
    """Of the template itself."""
    weights: Floats
    """(rows * columns, 2 * places in a row): from as many rows of what is read to the mean inside
    the template and the mean around it, at each place in a row."""


def fit_finger(mask: Floats, guess: FingerFrame, radius_mm: float) -> Fit | None:
    """Return the finger near a guess, or None without one.

    `mask`: (h, w) 1 where this finger is for sure, -1 where it is not for sure, 0 where nothing is
    known; `guess`: in its pixels; `radius_mm`: of the tip.
    """
    template, unlikely = _template(radius_mm), _unlikely()
    layers = np.asarray(cv2.merge([mask, (mask != 0.0).astype(np.float32)]), np.float32)
    sums = _sums(blended(layers, guess, template.at), template)
    inside, around = sums[0] / (np.float32(UNKNOWN) + np.float32(1.0 - UNKNOWN) * sums[1])
    fit = inside - around
    likely = np.float32(WEIGHT) * fit - unlikely
    turn, row, column = np.unravel_index(int(np.argmax(likely)), likely.shape)
    quality = float(fit[turn, row, column])
    if quality < LEAST_FIT:
        return None
    ahead, aside = _mean_around(likely[turn], int(row), int(column))
    place = guess.turned(math.radians(TURNS_DEG[turn]))
    return Fit(place.moved(STEP_MM * ahead - ALONG_MM, STEP_MM * aside - ACROSS_MM), quality)


def _sums(seen: Floats, template: _Template) -> Floats:
    """Return the weighted sums of each layer inside and around the template at all places.

    `seen`: (turns * rows, columns, layers); returns (layers, 2, turns, places along, across). One
    product of matrices: a filter for each turn, layer and mean costs four times as much.
    """
    turns, columns = len(TURNS_DEG), seen.shape[1]
    strips = sliding_window_view(seen.reshape(turns, -1, columns, 2), template.rows, axis=1)
    flat = strips.transpose(3, 0, 1, 4, 2).reshape(-1, len(template.weights))
    sums = (flat @ template.weights).reshape(2, turns, strips.shape[1], 2, -1)
    return np.asarray(sums.transpose(0, 3, 1, 2, 4))


def _mean_around(likely: Floats, row: int, column: int) -> tuple[float, float]:
    """Return the mean place around the most likely one, in rows and columns.

    A finger that is broader than the template fits equally well at several places.
    """
    top, left = max(row - AROUND, 0), max(column - AROUND, 0)
    weight = np.exp(
        likely[top : row + AROUND + 1, left : column + AROUND + 1] - likely[row, column]
    )
    total = float(weight.sum())
    ahead = float(weight.sum(axis=1) @ np.arange(weight.shape[0])) / total
    aside = float(weight.sum(axis=0) @ np.arange(weight.shape[1])) / total
    return top + ahead, left + aside


@lru_cache(maxsize=8)
def _template(radius_mm: float) -> _Template:
    ahead, aside = math.ceil(BESIDE_MM / STEP_MM), math.ceil((radius_mm + BESIDE_MM) / STEP_MM)
    behind = round(LENGTH_MM / STEP_MM)
    # The first row is the farthest behind, as in the grid that it is moved over.
    along = STEP_MM * np.arange(-behind, ahead + 1)[:, None]
    across = STEP_MM * np.arange(-aside, aside + 1)[None, :]
    beyond = np.hypot(np.maximum(along + radius_mm, 0.0), across) - radius_mm
    inside = np.clip(0.5 - beyond / STEP_MM, 0.0, 1.0)
    around = (1.0 - inside) * np.clip(0.5 + (BESIDE_MM - beyond) / STEP_MM, 0.0, 1.0)
    rows, columns = inside.shape
    places = 2 * round(ACROSS_MM / STEP_MM) + 1
    weights = np.zeros((rows, places + columns - 1, 2, places), np.float32)
    for place in range(places):
        weights[:, place : place + columns, 0, place] = inside / inside.sum()
        weights[:, place : place + columns, 1, place] = around / around.sum()
    # One turn below the other, as an image.
    at = (each.reshape(-1, weights.shape[1]) for each in _turned(_places(behind, ahead, aside)))
    return _Template(Grid(*at), rows, weights.reshape(-1, 2 * places))


def _places(behind: int = 0, ahead: int = 0, aside: int = 0) -> Grid:
    """Return the places that are tried for the end, and so many rows and columns around them."""
    rows, columns = round(ALONG_MM / STEP_MM), round(ACROSS_MM / STEP_MM)
    steps = grid(
        np.arange(-rows - behind, rows + ahead + 1),
        np.arange(-columns - aside, columns + aside + 1),
    )
    size = np.float32(STEP_MM)
    return Grid(steps.along * size, steps.across * size)


def _turned(at: Grid) -> Grid:
    """Return a grid in all directions that are tried: (turns, rows, columns)."""
    turns = np.radians(TURNS_DEG)[:, None, None]
    along = np.cos(turns) * at.along - np.sin(turns) * at.across
    across = np.sin(turns) * at.along + np.cos(turns) * at.across
    return Grid(along.astype(np.float32), across.astype(np.float32))


@lru_cache(maxsize=1)
def _unlikely() -> Floats:
    """Return the negative logarithm of the probability of each place, by the guess's errors.

    (turns, places along, across). Large errors are more frequent than a normal distribution has
    them.
    """
    along, across = _turned(_places())
    degrees = np.array(TURNS_DEG)[:, None, None]
    return np.asarray(
        np.log1p(0.5 * (along / ERROR_ALONG_MM) ** 2)
        + np.log1p(0.5 * (across / ERROR_ACROSS_MM) ** 2)
        + 0.5 * (degrees / ERROR_DEG) ** 2,
        np.float32,
    )
