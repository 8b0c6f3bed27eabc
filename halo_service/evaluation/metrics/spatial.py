"""Where a touch was reported and where it was: in the plane, in the frame that reported it.

Our error is measured from the pad's true place: of all hits, so within 25 mm of the target, with
nothing else removed. The paper measured from the targets, so with the people's own scatter, after
removing the common offset and outliers beyond three standard deviations (5.3.2). The report shows
both.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from halo_service.evaluation.metrics.touches import Hit

CHI2_95 = 5.991
"""95 % of a normal cloud in the plane lie within this squared distance, in sigmas."""
OUTLIER_SD = 3.0
"""Paper 5.3.2."""

Errors = NDArray[np.float64]
"""(N, 2) mm, reported minus true, surface frame."""


@dataclass(frozen=True, slots=True)
class Ellipse:
    """Where 95 % of a normal cloud lie."""

    x_mm: float
    y_mm: float
    """Its middle."""
    major_mm: float
    minor_mm: float
    """Half axes."""
    angle_deg: float
    """Of the major axis, from x towards y."""


@dataclass(frozen=True, slots=True)
class Spatial:
    """How far off the touches were."""

    count: int
    mean_mm: float
    sd_mm: float
    median_mm: float
    p95_mm: float
    bias_mm: tuple[float, float]
    ellipse: Ellipse


def from_truth(hits: Sequence[Hit]) -> Errors:
    """Return how far each touch was reported from the pad's place in that frame."""
    rows = [(h.down.x_mm - h.true_mm[0], h.down.y_mm - h.true_mm[1]) for h in hits]
    return np.array(rows, np.float64).reshape(-1, 2)


def from_target(hits: Sequence[Hit]) -> Errors:
    """Return how far each touch that had a target was reported from it."""
    rows = [
        (h.down.x_mm - h.touch.target_mm[0], h.down.y_mm - h.touch.target_mm[1])
        for h in hits
        if h.touch.target_mm
    ]
    return np.array(rows, np.float64).reshape(-1, 2)


def as_the_paper(errors: Errors) -> Errors:
    """Return errors from the targets without their common offset and outliers."""
    if not len(errors):
        return errors
    centred = np.asarray(errors - errors.mean(axis=0), np.float64)
    away = np.hypot(*centred.T)
    return np.asarray(centred[away <= away.mean() + OUTLIER_SD * away.std()])


def spatial(errors: Errors) -> Spatial | None:
    """Sum up errors; None where there are none."""
    if not len(errors):
        return None
    away = np.hypot(*errors.T)
    bias = errors.mean(axis=0)
    return Spatial(
        len(errors),
        float(away.mean()),
        float(away.std()),
        float(np.median(away)),
        float(np.percentile(away, 95.0)),
        (float(bias[0]), float(bias[1])),
        ellipse(errors),
    )


def ellipse(places: Errors) -> Ellipse:
    """Return the ellipse that holds 95 % of a normal cloud like these (N >= 1) places."""
    x, y = places.mean(axis=0)
    spread = np.cov(places.T) if len(places) > 1 else np.zeros((2, 2))
    sizes, axes = np.linalg.eigh(spread)
    minor, major = np.sqrt(CHI2_95 * np.maximum(sizes, 0.0))
    along = axes[:, 1]
    angle = float(np.degrees(np.arctan2(along[1], along[0])))
    return Ellipse(float(x), float(y), float(major), float(minor), angle % 180.0)
