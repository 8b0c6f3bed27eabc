"""The image for the hand tracker: 0.7 infrared + 0.3 colour, in the depth camera's view.

Rule: pure. Projected light on a hand breaks a tracker that gets colour alone, and room light does
not reach the infrared: the paper blends both (section 4.3). Colour is warped to the depth
camera's pixels, so that a landmark in the image is a depth pixel.
"""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from halo_service.geometry.camera import Camera, Points
from halo_service.values import Depth, Infrared

Picture = NDArray[np.uint8]
Map = NDArray[np.float32]

IR_SHARE = 0.7
"""As in the paper, section 4.3; the rest is colour."""
_SATURATED = 65535
_WHITE_PERCENTILE = 99.0
"""Of the measured, unsaturated pixels: this percentile becomes white."""
_EVERY = 8
"""Step between the pixels that decide what is white: 5,760 are plenty."""
SHRINK = 2
"""Colour is decoded and sampled at half its size, which is as fine as depth."""
_EXACT_AT_MM = (350.0, 800.0)
"""Depths where `ColourWarp` is exact; it is used from 300 to 1000 mm."""
_GRID_PX = 8
"""The projections are exact on this grid and linear between: 64 times less work at the start."""


class ColourWarp:
    """Where each depth pixel is in the half-size colour image, by its depth.

    A pixel at depth z is the point z * ray, and the colour camera sees it in the direction
    R ray + t / z: the same direction but for a short step in 1 / z. So its place there is
    approximated as A + B / z, with A and B from two exact projections: less than half a colour
    pixel off from 300 to 1000 mm (tested), for one multiplication and one addition a pixel.
    """

    def __init__(self, camera: Camera, background_mm: Map) -> None:
        """`background_mm`: (H, W), the depth to use where a frame has none; mm, above 0."""
        self._shape = (camera.depth.height, camera.depth.width)
        if background_mm.shape != self._shape:
            raise ValueError(f"a background of {background_mm.shape} does not fit the camera")
        self._background = np.reciprocal(background_mm, dtype=np.float32)
        self._line = None if camera.colour is None else self._exact_line(camera)

    def places(self, depth: Depth) -> Map | None:
        """Return (2, H, W) float32: x and y in the half-size colour image, px.

        None: this camera has no colour.
        """
        if self._line is None:
            return None
        with np.errstate(divide="ignore"):
            inverse = np.reciprocal(depth, dtype=np.float32)
        np.copyto(inverse, self._background, where=depth == 0)
        at_infinity, per_inverse_mm = self._line
        places: Map = per_inverse_mm * inverse
        places += at_infinity
        return places

    def _exact_line(self, camera: Camera) -> tuple[Map, Map]:
        height, width = self._shape
        rows, columns = _grid(height), _grid(width)
        px = np.stack(np.meshgrid(columns, rows), axis=-1).reshape(-1, 2)
        rays = camera.depth.rays(px)
        near, far = (_in_colour(camera, rays * z) for z in _EXACT_AT_MM)
        per_inverse_mm = (near - far) / (1 / _EXACT_AT_MM[0] - 1 / _EXACT_AT_MM[1])
        at_infinity = near - per_inverse_mm / _EXACT_AT_MM[0]
        return self._as_map(at_infinity), self._as_map(per_inverse_mm)

    def _as_map(self, px: Points) -> Map:
        """Fill the pixels between the grid's: over so few, a lens is nearly linear."""
        height, width = self._shape
        rows, columns = _grid(height), _grid(width)
        coarse = px.T.reshape(2, len(rows), len(columns))
        filled = _between(rows, height) @ coarse @ _between(columns, width).T
        return np.ascontiguousarray(filled, dtype=np.float32)


def _grid(length: int) -> Points:
    """Every eighth pixel, and one past the last."""
    return np.arange(0.0, length + _GRID_PX, _GRID_PX)


def _between(grid: Points, length: int) -> Points:
    """(length, len(grid)): the weights of linear interpolation, a row a pixel."""
    distance = np.abs(np.arange(length)[:, None] - grid[None, :]) / _GRID_PX
    return np.maximum(1.0 - distance, 0.0)


def blend(
    ir: Infrared, colour: NDArray[np.uint8] | bytes | None, warp: ColourWarp, depth: Depth
) -> Picture:
    """Return (H, W, 3) uint8 RGB for the hand tracker.

    Without colour, or with a JPEG that cannot be decoded, it shows the infrared alone.
    """
    grey = cv2.cvtColor(toned(ir), cv2.COLOR_GRAY2RGB)
    small = None if colour is None else _small(colour)
    places = None if small is None else warp.places(depth)
    if small is None or places is None:
        return np.asarray(grey, dtype=np.uint8)
    x, y = places
    # Outside the colour camera's view its border is repeated: black would look like an edge.
    seen = cv2.remap(small, x, y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    return np.asarray(cv2.addWeighted(grey, IR_SHARE, seen, 1 - IR_SHARE, 0), dtype=np.uint8)


def toned(ir: Infrared) -> Picture:
    """Return (H, W) uint8: the root of the infrared, as light falls with the distance squared."""
    sample = ir[::_EVERY, ::_EVERY]
    measured = sample[(sample > 0) & (sample < _SATURATED)]
    white = float(np.percentile(measured, _WHITE_PERCENTILE)) if measured.size else _SATURATED
    tones = np.sqrt(ir, dtype=np.float32)
    tones *= np.float32(255 / np.sqrt(white))
    return np.minimum(tones, 255, out=tones).astype(np.uint8)


def _in_colour(camera: Camera, points: Points) -> Points:
    """(N, 3) mm in the depth camera's frame to (N, 2) pixels of the half-size colour image."""
    assert camera.colour is not None
    pose = camera.colour_from_depth
    px = camera.colour.project(points @ pose[:3, :3].T + pose[:3, 3])
    # From centre to corner of the pixel, where sizes scale, and back.
    return (px + 0.5) / SHRINK - 0.5


def _small(colour: NDArray[np.uint8] | bytes) -> Picture | None:
    """(h / 2, w / 2, 3) uint8 RGB, or None where the JPEG is broken."""
    if isinstance(colour, bytes):
        data = np.frombuffer(colour, np.uint8)
        small = cv2.imdecode(data, cv2.IMREAD_REDUCED_COLOR_2) if data.size else None
        if small is None:
            return None
    else:
        size = (colour.shape[1] // SHRINK, colour.shape[0] // SHRINK)
        small = cv2.resize(colour, size, interpolation=cv2.INTER_AREA)
    return np.asarray(cv2.cvtColor(small, cv2.COLOR_BGR2RGB), dtype=np.uint8)
