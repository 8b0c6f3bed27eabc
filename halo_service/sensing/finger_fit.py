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
    inside: Floats
    around: Floats
    """(rows, columns): weights of two means."""
    anchor: tuple[int, int]
    """Column and row of the finger's end."""


def fit_finger(mask: Floats, guess: FingerFrame, radius_mm: float) -> Fit | None:
    """Return the finger near a guess, or None without one.

    `mask`: (h, w) 1 where this finger is for sure, -1 where it is not for sure, 0 where nothing is
    known; `guess`: in its pixels; `radius_mm`: of the tip.
    """
    template, margin = _template(radius_mm), round(LENGTH_MM / STEP_MM) + 1
    at = _places(margin)
    layers = np.asarray(cv2.merge([mask, (mask != 0.0).astype(np.float32)]), np.float32)
    best, most = None, -math.inf
    for degrees in TURNS_DEG:
        place = guess.turned(math.radians(degrees))
        seen = blended(layers, place, at)
        fit = _mean(seen, template.inside, template) - _mean(seen, template.around, template)
        inner = fit[margin:-margin, margin:-margin]
        likely = np.float32(WEIGHT) * inner - _unlikely(degrees)
        row, column = divmod(int(np.argmax(likely)), likely.shape[1])
        if likely[row, column] > most:
            most = float(likely[row, column])
            ahead, aside = _mean_around(likely, row, column)
            place = place.moved(STEP_MM * ahead - ALONG_MM, STEP_MM * aside - ACROSS_MM)
            best = Fit(place, float(inner[row, column]))
    return best if best is not None and best.quality >= LEAST_FIT else None


def _mean(layers: Floats, weights: Floats, template: _Template) -> Floats:
    """Return the mean of the first layer around each sample, over what the second one knows."""
    sums = np.asarray(cv2.filter2D(layers, cv2.CV_32F, weights, anchor=template.anchor))
    known = np.float32(UNKNOWN) + np.float32(1.0 - UNKNOWN) * sums[..., 1]
    return np.asarray(sums[..., 0] / known, np.float32)


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
    return _Template(
        (inside / inside.sum()).astype(np.float32),
        (around / around.sum()).astype(np.float32),
        (aside, behind),
    )


@lru_cache(maxsize=2)
def _places(margin: int) -> Grid:
    """Return the places that are tried for the end, and as many rows and columns around them."""
    rows, columns = (round(each / STEP_MM) + margin for each in (ALONG_MM, ACROSS_MM))
    steps = grid(np.arange(-rows, rows + 1), np.arange(-columns, columns + 1))
    size = np.float32(STEP_MM)
    return Grid(steps.along * size, steps.across * size)


@lru_cache(maxsize=len(TURNS_DEG))
def _unlikely(degrees: float) -> Floats:
    """Return the negative logarithm of the probability of each place, by the guess's errors.

    Large errors are more frequent than a normal distribution has them.
    """
    (along, across), turn = _places(0), math.radians(degrees)
    ahead = math.cos(turn) * along - math.sin(turn) * across
    aside = math.sin(turn) * along + math.cos(turn) * across
    return np.asarray(
        np.log1p(0.5 * (ahead / ERROR_ALONG_MM) ** 2)
        + np.log1p(0.5 * (aside / ERROR_ACROSS_MM) ** 2)
        + 0.5 * (degrees / ERROR_DEG) ** 2,
        np.float32,
    )
