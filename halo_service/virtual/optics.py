"""What happens to light between a body and a pixel: motion, edges, stray light, shadow.

Rule: each function changes an ideal image as one published effect of the sensor does;
`sensor_model` has the parameters and their sources. Boxes keep the work near the bodies.
"""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from halo_service.geometry.camera import Lens
from halo_service.virtual.boxes import Box
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

Places = tuple[NDArray[np.intp], NDArray[np.intp]]
"""Rows and columns of single pixels."""


def soften_edges(
    ideal: Ideal, table: Image, model: SensorModel, rng: np.random.Generator
) -> Places | None:
    """Mix pixels along silhouettes, in place; return where they read nothing."""
    box = ideal.around(4)
    if box is None:
        return None
    depth, covered, moving = ideal.depth[box], ideal.covered[box], ideal.moving[box]
    wide = np.ones((model.edge_width_px, model.edge_width_px), np.uint8)
    edge = np.bitwise_or(cv2.morphologyEx(covered, cv2.MORPH_GRADIENT, wide), moving)
    lost = _lost(depth, moving, edge, model, rng)
    cv2.copyTo(cv2.GaussianBlur(depth, (0, 0), model.edge_sigma_px), edge, dst=depth)
    # A finger lower than that is averaged with the table around it: its outline fades.
    low = covered * (table[box] - depth < EDGE_STEP_MM)
    averaged = cv2.addWeighted(depth, 1.0 - AVERAGED, cv2.blur(depth, (5, 5)), AVERAGED, 0.0)
    cv2.copyTo(averaged, low, dst=depth)
    return _in_image(lost, box)


def _lost(
    depth: Image,
    moving: NDArray[np.uint8],
    edge: NDArray[np.uint8],
    model: SensorModel,
    rng: np.random.Generator,
) -> Places:
    """The places along silhouettes that read nothing: many where the step is high."""
    step = cv2.morphologyEx(depth, cv2.MORPH_GRADIENT, np.ones((3, 3), np.uint8))
    at = np.flatnonzero(((step > EDGE_STEP_MM) | (moving > 0)) & (edge > 0))
    loss = np.where(moving.ravel().take(at) > 0, model.moving_edge_loss, model.edge_loss)
    lost = at[rng.random(len(at), np.float32) < loss]
    return lost // depth.shape[1], lost % depth.shape[1]


def _in_image(places: Places, box: Box) -> Places:
    """From the box to the image."""
    return places[0] + box[0].start, places[1] + box[1].start


def add_stray_light(ideal: Ideal, table: Image, model: SensorModel, lens: Lens) -> Box | None:
    """Let what lies next to a raised thing read nearer, in place; return where."""
    times = px_times(lens)
    box = ideal.around(round(3.0 * LONG_PX * times)) if model.stray_light else None
    if box is None:
        return None
    box = _aligned(box)
    # Outside the bodies nothing is raised: the halo lies below the table.
    raised = cv2.subtract(table[box], ideal.depth[box])
    cv2.add(raised, ideal.late[box], dst=raised)
    rows, columns = raised.shape
    size = columns // STRAY_TIMES, rows // STRAY_TIMES
    raised = np.maximum(cv2.resize(raised, size, interpolation=cv2.INTER_AREA), 0.0)
    # A wide plane of one height reads right: only what is lower than its surroundings is lifted.
    nearer = raised * np.float32(-(SHORT_SHARE + LONG_SHARE) * model.stray_light)
    for sigma, share in ((SHORT_PX, SHORT_SHARE), (LONG_PX, LONG_SHARE)):
        blurred = cv2.GaussianBlur(
            raised, (0, 0), sigma * times / STRAY_TIMES, borderType=cv2.BORDER_REPLICATE
        )
        cv2.scaleAdd(blurred, share * model.stray_light, nearer, dst=nearer)
    nearer = np.maximum(nearer, 0.0)
    ideal.depth[box] -= cv2.resize(nearer, (columns, rows), interpolation=cv2.INTER_LINEAR)
    return box


def cast_shadow(
    ideal: Ideal, table: Image, model: SensorModel, lens: Lens, rng: np.random.Generator
) -> Places | None:
    """Darken what the illuminator does not reach next to a body, in place; it reads late, or
    nothing: return where."""
    box = ideal.around(WIDEST_SHADOW_PX, 0) if model.illuminator_mm else None
    if box is None:
        return None
    covered, there = ideal.covered[box], table[box]
    here = cv2.subtract(ideal.depth[box], ideal.late[box])
    column = np.arange(covered.shape[1], dtype=np.float32)
    # How far the illuminator's view differs from ours: a body darkens what is so far to its left.
    shift = np.float32(lens.fx * model.illuminator_mm)
    left_px = shift / there - shift / here
    farthest = min(covered.shape[1], 2 + int(-left_px.min()))
    free = covered == 0
    left_px += column
    np.copyto(left_px, np.inf, where=free)
    leftmost = cv2.erode(left_px, np.ones((1, farthest + 1), np.uint8), anchor=(0, 0))
    at = np.flatnonzero((leftmost <= column + np.float32(0.5)) & free)
    dark = _in_image((at // covered.shape[1], at % covered.shape[1]), box)
    count = len(at)
    ideal.infrared[dark] *= np.float32(model.shadow_light)
    late = rng.standard_exponential(count, np.float32)
    ideal.depth[dark] += np.float32(model.shadow_late_mm) * late
    lost = rng.random(count, np.float32) < model.shadow_loss
    return dark[0][lost], dark[1][lost]


def _aligned(box: Box) -> Box:
    """Grown to whole blocks of stray light; images are whole blocks in every mode."""
    rows, columns = (
        slice(s.start // STRAY_TIMES * STRAY_TIMES, -(-s.stop // STRAY_TIMES) * STRAY_TIMES)
        for s in box
    )
    return rows, columns
