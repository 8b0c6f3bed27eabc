"""What happens to light between a body and a pixel: motion, edges, stray light, shadow.

Rule: each function changes an ideal image as one published effect of the sensor does;
`sensor_model` has the parameters and their sources. Boxes keep the work near the bodies.
"""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from halo_service.geometry.camera import Lens
from halo_service.virtual.camera import px_times
from halo_service.virtual.depth_image import Ideal
from halo_service.virtual.exposure import EDGE_STEP_MM
from halo_service.virtual.scene import Image
from halo_service.virtual.sensor_model import SensorModel

AVERAGED = 0.5
"""Share of its surroundings in what a low finger reads. Chosen."""
SHORT_PX, SHORT_SHARE = 6.0, 0.062
LONG_PX, LONG_SHARE = 16.0, 0.102
"""Two Gaussians of stray light: sigma, and share of the light. Beside a straight edge they give
5.1, 3.0 and 1.3 % of the height at 5, 10 and 18 px, where frames of augcog/OpenARK_test show 5.3,
3.0 and 1.3 %."""
STRAY_TIMES = 4
"""Stray light is computed on an image so many times smaller: it has no fine structure."""
WIDEST_SHADOW_PX = 24

Box = tuple[slice, slice]


def soften_edges(
    ideal: Ideal, table: Image, model: SensorModel, rng: np.random.Generator
) -> tuple[Box, NDArray[np.bool_]] | None:
    """Mix pixels along silhouettes, in place; return where they read nothing."""
    box = _around(ideal.covered, 4)
    if box is None:
        return None
    depth, covered, moving = ideal.depth[box], ideal.covered[box], ideal.moving[box] > 0
    kernel = np.ones((3, 3), np.uint8)
    wide = np.ones((model.edge_width_px, model.edge_width_px), np.uint8)
    edge = (cv2.dilate(covered, wide) != cv2.erode(covered, wide)) | moving
    step = cv2.dilate(depth, kernel) - cv2.erode(depth, kernel)
    loss = (step > EDGE_STEP_MM) * np.float32(model.edge_loss)
    np.copyto(loss, model.moving_edge_loss, where=moving)
    lost = edge & (rng.random(depth.shape, np.float32) < loss)
    mixed = cv2.GaussianBlur(depth, (0, 0), model.edge_sigma_px)
    np.copyto(depth, mixed, where=edge)
    # A finger lower than that is averaged with the table around it: its outline fades.
    low = (covered > 0) & (table[box] - depth < EDGE_STEP_MM)
    averaged = (1.0 - AVERAGED) * depth + AVERAGED * cv2.blur(depth, (5, 5))
    np.copyto(depth, averaged, where=low)
    return box, np.asarray(lost, dtype=np.bool_)


def add_stray_light(ideal: Ideal, table: Image, model: SensorModel, lens: Lens) -> None:
    """Let what lies next to a raised thing read nearer, in place."""
    times = px_times(lens)
    box = _around(ideal.covered, round(3.0 * LONG_PX * times)) if model.stray_light else None
    if box is None:
        return
    box = _aligned(box)
    rows, columns = ideal.depth[box].shape
    size = columns // STRAY_TIMES, rows // STRAY_TIMES
    there, here, late = (
        cv2.resize(image[box], size, interpolation=cv2.INTER_AREA)
        for image in (table, ideal.depth, ideal.late)
    )
    raised: Image = np.maximum(there - here + late, 0.0)
    # A wide plane of one height reads right: only what is lower than its surroundings is lifted.
    nearer = raised * np.float32(-(SHORT_SHARE + LONG_SHARE) * model.stray_light)
    for sigma, share in ((SHORT_PX, SHORT_SHARE), (LONG_PX, LONG_SHARE)):
        blurred = cv2.GaussianBlur(
            raised, (0, 0), sigma * times / STRAY_TIMES, borderType=cv2.BORDER_REPLICATE
        )
        cv2.scaleAdd(blurred, share * model.stray_light, nearer, dst=nearer)
    nearer = np.maximum(nearer, 0.0)
    ideal.depth[box] -= cv2.resize(nearer, (columns, rows), interpolation=cv2.INTER_LINEAR)


def cast_shadow(
    ideal: Ideal, table: Image, model: SensorModel, lens: Lens, rng: np.random.Generator
) -> tuple[Box, NDArray[np.bool_]] | None:
    """Darken what the illuminator does not reach next to a body, in place; it reads late, or
    nothing: return where."""
    box = _around(ideal.covered, WIDEST_SHADOW_PX, 0) if model.illuminator_mm else None
    if box is None:
        return None
    covered = ideal.covered[box] > 0
    here = ideal.depth[box] - ideal.late[box]
    column = np.arange(covered.shape[1], dtype=np.float32)
    # How far the illuminator's view differs from ours: a body darkens what is so far to its left.
    left_px = np.float32(lens.fx * model.illuminator_mm) * (here - table[box])
    left_px /= here
    left_px /= table[box]
    farthest = min(covered.shape[1], 2 + int(-left_px.min()))
    darkens = left_px + column
    np.copyto(darkens, np.inf, where=~covered)
    leftmost = cv2.erode(darkens, np.ones((1, farthest + 1), np.uint8), anchor=(0, 0))
    shade = (leftmost <= column + np.float32(0.5)) & ~covered
    dark = np.unravel_index(np.flatnonzero(shade), shade.shape)
    count = len(dark[0])
    ideal.infrared[box][dark] *= np.float32(model.shadow_light)
    ideal.depth[box][dark] += np.float32(model.shadow_late_mm) * rng.standard_exponential(
        count, np.float32
    )
    shade[dark] = rng.random(count, np.float32) < model.shadow_loss
    return box, shade


def clipped(
    low: tuple[float, float] | NDArray[np.float64],
    high: tuple[float, float] | NDArray[np.float64],
    shape: tuple[int, ...],
) -> Box:
    """Rows and columns from two corners (x, y), within the image."""
    (x0, y0), (x1, y1) = low, high
    rows = slice(max(0, int(y0)), max(0, min(shape[0], int(y1) + 1)))
    return rows, slice(max(0, int(x0)), max(0, min(shape[1], int(x1) + 1)))


def _aligned(box: Box) -> Box:
    """Grown to whole blocks of stray light; images are whole blocks in every mode."""
    rows, columns = (
        slice(s.start // STRAY_TIMES * STRAY_TIMES, -(-s.stop // STRAY_TIMES) * STRAY_TIMES)
        for s in box
    )
    return rows, columns


def _around(mask: NDArray[np.uint8], margin_px: int, above_px: int | None = None) -> Box | None:
    """The mask's bounding box with a margin, above and below `above_px`; None: it is empty."""
    x, y, width, height = cv2.boundingRect(mask)
    if width == 0:
        return None
    above_px = margin_px if above_px is None else above_px
    low, high = (x - margin_px, y - above_px), (x + width + margin_px, y + height + above_px)
    return clipped(low, high, mask.shape)
