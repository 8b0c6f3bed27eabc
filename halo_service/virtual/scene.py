"""The empty table as a lens sees it: where each pixel looks, and what is reflected there.

Rule: ideal light only, no noise. (H, W) float32 throughout.
"""

from __future__ import annotations

import functools
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from halo_service.geometry.camera import Lens, Points
from halo_service.virtual.camera import pixel_rays
from halo_service.virtual.materials import Material
from halo_service.virtual.props import FLAT, Flat
from halo_service.virtual.room import Room

Image = NDArray[np.float32]

IR_GAIN = 6400.0
"""Counts of a white diffuser at 0.5 m. A desk in a public recording of a real device reads about
500 at 1.45 m: as many at the reflectances of `materials`."""
VIGNETTE = 3.0
"""Power of the cosine by which illumination and lens darken the corners; chosen below the
natural 4, as the illuminator makes up for some."""
SPECKLE_MM = 1.5


@dataclass(frozen=True, slots=True, eq=False)
class View:
    """The plane of the table through one lens."""

    depth: Image
    """mm along the lens's axis."""
    x_mm: Image
    y_mm: Image
    """Where on the surface each pixel looks."""
    distance_mm: Image
    """From the lens."""
    facing: Image
    """Cosine between the ray and the table's normal."""


def look(lens: Lens, lens_from_surface: Points) -> View:
    """Cut each pixel's ray with the plane. The arrays are shared: they cannot be written to."""
    return _look(lens, lens_from_surface.astype(np.float64).tobytes())


@functools.lru_cache(maxsize=2)  # the two lenses of a device: most rooms are drawn more than once
def _look(lens: Lens, matrix: bytes) -> View:
    lens_from_surface = np.frombuffer(matrix, np.float64).reshape(4, 4)
    rays = pixel_rays(lens)
    normal, origin = lens_from_surface[:3, 2], lens_from_surface[:3, 3]
    # A ray that never meets the plane (above the horizon) ends far away.
    towards = np.maximum(rays @ normal, 0.05)
    depth = (origin @ normal) / towards
    points = rays * depth[..., None] - origin
    length = np.linalg.norm(rays, axis=2)
    return View(
        *map(
            _frozen,
            (
                depth,
                points @ lens_from_surface[:3, 0],
                points @ lens_from_surface[:3, 1],
                depth * length,
                towards / length,
            ),
        )
    )


def _frozen(image: Points) -> Image:
    single = image.astype(np.float32)
    single.flags.writeable = False
    return single


def illumination(view: View) -> Image:
    """Infrared counts that a white diffuser facing the camera would give at the table."""
    vignette = (view.depth / view.distance_mm) ** VIGNETTE
    return np.asarray(IR_GAIN * vignette * (500.0 / view.distance_mm) ** 2, dtype=np.float32)


@dataclass(frozen=True, slots=True, eq=False)
class Top:
    """What the table's top reflects, pixel by pixel, and how much halo it grows."""

    infrared: Image
    colour: Image
    """(H, W, 3) blue green red."""
    halo: Image


def top(view: View, room: Room) -> Top:
    """The material with its grain, and the flat things on it."""
    material = room.surface_material
    shade = grain(material, view.x_mm, view.y_mm)
    infrared = material.infrared * shade
    colour = np.array(material.colour, np.float32) * shade[..., None]
    halo = np.full(shade.shape, material.halo, np.float32)
    for name in room.props:
        if name in FLAT:
            _lay(FLAT[name](), view, infrared, colour, halo)
    for sheet in room.sheets:
        _lay(sheet, view, infrared, colour, halo)
    return Top(infrared.astype(np.float32), colour.astype(np.float32), halo)


def _lay(flat: Flat, view: View, infrared: Image, colour: Image, halo: Image) -> None:
    """Print a flat thing over what is there, in place."""
    turn = np.radians(flat.turn_deg)
    dx, dy = view.x_mm - flat.x_mm, view.y_mm - flat.y_mm
    u = (dx * np.cos(turn) + dy * np.sin(turn)) / flat.width_mm + 0.5
    v = (dy * np.cos(turn) - dx * np.sin(turn)) / flat.height_mm + 0.5
    on = (u >= 0.0) & (u < 1.0) & (v >= 0.0) & (v < 1.0)
    print_ = _as_fine_as(view, flat)
    rows, columns = print_.shape
    printed = cv2.remap(
        print_,
        (u * columns - 0.5).astype(np.float32),
        (v * rows - 0.5).astype(np.float32),
        cv2.INTER_LINEAR,
        borderMode=cv2.BORDER_REPLICATE,
    )
    infrared[on], colour[on], halo[on] = printed[on], printed[on][:, None], flat.halo


def _as_fine_as(view: View, flat: Flat) -> Image:
    """The print at two dots a pixel of the lens: a pixel averages over its area, so a finer
    print would come out jagged."""
    pixel_mm = float(np.median(np.abs(np.diff(view.x_mm, axis=1))))
    rows, columns = flat.print.shape
    times = 2.0 * flat.width_mm / (columns * pixel_mm)
    if times >= 1.0:
        return flat.print
    size = max(1, round(columns * times)), max(1, round(rows * times))
    small = cv2.resize(flat.print, size, interpolation=cv2.INTER_AREA)
    return np.asarray(cv2.GaussianBlur(small, (3, 3), 0.8), dtype=np.float32)


def grain(material: Material, x_mm: Image, y_mm: Image) -> Image:
    """Brightness of the material's texture around 1, from the place alone."""
    if material.grain == "plain" or material.contrast == 0.0:
        return np.ones_like(x_mm)
    if material.grain == "wood":
        warp = 4.0 * np.sin(x_mm / 97.0 + 0.8) + 2.0 * np.sin(x_mm / 31.0)
        rings = np.sin((y_mm + warp) / 2.9) + 0.6 * np.sin((y_mm + 1.7 * warp) / 11.0)
        return np.asarray(1.0 + 0.6 * material.contrast * rings, dtype=np.float32)
    tile = np.random.default_rng(7).normal(0.0, 0.5, (256, 256)).astype(np.float32)
    tile = tile + np.roll(tile, 1, 0) + np.roll(tile, 1, 1) + np.roll(tile, (1, 1), (0, 1))
    u = np.asarray(x_mm / SPECKLE_MM, np.int64) & 255
    v = np.asarray(y_mm / SPECKLE_MM, np.int64) & 255
    return np.asarray(1.0 + material.contrast * tile[v, u], dtype=np.float32)
