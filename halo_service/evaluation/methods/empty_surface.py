"""The empty surface for rivals that need no hand tracker: heights above it.

Rule: only the part of the image in which a finger can be near the surface is used.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from halo_service.geometry.camera import Camera
from halo_service.geometry.surface import Surface
from halo_service.profile import Profile
from halo_service.values import Depth

AROUND_MM = 60.0
"""The image is used this far around the surface (chosen: a hand's width beyond the edge)."""

Heights = NDArray[np.float32]
Pixel = tuple[float, float]


@dataclass(frozen=True, slots=True, eq=False)
class EmptySurface:
    """The empty surface within a window of the image."""

    rows: slice
    columns: slice
    """The window."""
    mean_mm: Heights
    noise_mm: Heights
    """(h, w) mean depth and its standard deviation, of the window."""
    valid: NDArray[np.bool_]
    """(h, w) where the empty surface was measured."""


def crop_empty_surface(profile: Profile) -> EmptySurface:
    """Cut the window out of a profile's background."""
    surface, lens = profile.surface, profile.camera.depth
    corners = [
        (x, y, 0.0)
        for x in (-AROUND_MM, surface.width_mm + AROUND_MM)
        for y in (-AROUND_MM, surface.height_mm + AROUND_MM)
    ]
    px = lens.project(surface.to_camera(np.array(corners)))
    (left, top), (right, bottom) = px.min(axis=0).tolist(), px.max(axis=0).tolist()
    rows = slice(max(int(top), 0), min(max(int(bottom), 0), lens.height))
    columns = slice(max(int(left), 0), min(max(int(right), 0), lens.width))
    background = profile.background
    return EmptySurface(
        rows,
        columns,
        background.mean_mm[rows, columns],
        background.noise_mm[rows, columns],
        background.valid[rows, columns],
    )


def heights(ground: EmptySurface, depth: Depth, drift_mm: float) -> Heights:
    """Return (h, w) float32, mm: how much nearer each pixel is than the empty surface.

    0 where either measured nothing; `drift_mm`: how much farther the whole device reads by now.
    """
    window = depth[ground.rows, ground.columns]
    surface = ground.mean_mm + np.float32(drift_mm)
    nearer = np.asarray(cv2.subtract(surface, window, dtype=cv2.CV_32F), dtype=np.float32)
    nearer[(window == 0) | ~ground.valid] = 0.0
    return nearer


def pixel_in(ground: EmptySurface, column: float, row: float) -> Pixel:
    """Return the image's pixel for one of the window."""
    return column + ground.columns.start, row + ground.rows.start


def point_at(
    px: Pixel, height_mm: float, camera: Camera, surface: Surface
) -> tuple[float, float, float]:
    """Return the point of a pixel in the surface's frame, mm, if it is at that height."""
    ray = camera.depth.rays(np.array([px]))[0]
    normal, origin = surface.camera_from_surface[:3, 2], surface.camera_from_surface[:3, 3]
    scale = (normal @ origin - height_mm) / (normal @ ray)
    x, y, z = surface.from_camera((ray * scale)[None])[0].tolist()
    return x, y, z
