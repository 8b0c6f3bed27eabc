"""UBC-X-Lab/DepthTouchSensing: touches on a tablet, and the depth video of them, to truth.

Its label files are `touch_id, event, x, y, epoch_ms` a line, in points of the tablet. What is not
published, and therefore an option: where the tablet's screen is in the depth image, how many points
it has, and when in the video the first touch happens. The videos are said to be `.mkv` of an Azure
Kinect; with depth, infrared and calibration inside, `halo replay` reads them as they are.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from halo_service.app.datasets.truth_lines import Fingertip, Line, Who, frame_lines
from halo_service.errors import UserError
from halo_service.geometry.camera import Camera, Points
from halo_service.sources import EndOfSource, Source
from halo_service.values import Frame
from halo_service.virtual.scenarios.labels import Way, raw_touches

PLANE_FRAMES = 10
"""So many of the first frames say where the screen is."""
NEAR_PX = 12
"""Depth is read around each corner within this: a screen that shines has holes."""
LEAST_PIXELS = 30


@dataclass(frozen=True, slots=True)
class Placement:
    """What is not in the data set."""

    corners_px: tuple[tuple[float, float], ...]
    """Of the screen in the depth image: far left, far right, near right, near left."""
    screen: tuple[int, int]
    """Its width and height in points, as the labels count them."""
    first_touch_s: float
    """When the first touch begins, in seconds from the video's first frame."""


def convert(source: Source, labels: Path, placement: Placement) -> list[Line]:
    """Return the truth's lines. Raises UserError where the screen's depth cannot be read."""
    frames = list(_frames(source))
    if not frames:
        raise UserError("import-dataset: the video holds no frame with depth")
    corners_mm = screen_corners(frames[:PLANE_FRAMES], source.camera, placement.corners_px)
    ways = raw_touches(labels)
    shift_us = frames[0].time_us + round(1e6 * (placement.first_touch_s - ways[0][0].time_s))
    times = [frame.time_us for frame in frames]
    return list(frame_lines(_fingers(times, ways, shift_us, corners_mm, placement.screen)))


def screen_corners(
    frames: Sequence[Frame], camera: Camera, corners_px: Sequence[tuple[float, float]]
) -> Points:
    """(4, 3) mm in the depth camera's frame, on the plane that fits the depth around them."""
    depth = np.array([frame.depth for frame in frames], np.float64)
    depth[depth == 0.0] = np.nan
    px = np.array(corners_px, np.float64)
    points = [_around(depth, camera, corner) for corner in px]
    known = np.concatenate(points)
    if min(map(len, points)) < LEAST_PIXELS:
        raise UserError(
            "import-dataset: there is no depth around a corner of the screen; check --corners"
        )
    # z = a x + b y + c
    plane, *_ = np.linalg.lstsq(
        np.column_stack([known[:, :2], np.ones(len(known))]), known[:, 2], rcond=None
    )
    rays = camera.depth.rays(px)
    z = plane[2] / (1.0 - rays[:, 0] * plane[0] - rays[:, 1] * plane[1])
    return np.asarray(rays * z[:, None], dtype=np.float64)


def _around(depth: Points, camera: Camera, corner: Points) -> Points:
    """(N, 3) mm: the surface around a corner, as far as it is measured."""
    x, y = np.rint(corner).astype(int)
    rows, columns = np.mgrid[y - NEAR_PX : y + NEAR_PX + 1, x - NEAR_PX : x + NEAR_PX + 1]
    inside = (rows >= 0) & (rows < depth.shape[1]) & (columns >= 0) & (columns < depth.shape[2])
    rows, columns = rows[inside], columns[inside]
    seen = depth[:, rows, columns]
    measured = np.isfinite(seen).any(axis=0)
    z = np.nanmedian(seen[:, measured], axis=0)
    px = np.column_stack([columns[measured], rows[measured]]).astype(np.float64)
    return np.asarray(camera.depth.rays(px) * z[:, None], dtype=np.float64)


def _fingers(
    times_us: Sequence[int],
    ways: Sequence[Way],
    shift_us: int,
    corners_mm: Points,
    screen: tuple[int, int],
) -> Iterator[tuple[int, Mapping[Who, Fingertip]]]:
    """Yield each frame's touching fingers. Labels do not say which finger it is: index, then the
    others in order."""
    names = ("index", "middle", "ring", "little", "thumb")
    for time_us in times_us:
        found: dict[Who, Fingertip] = {}
        down = [way for way in ways if _during(way, time_us, shift_us)]
        for name, way in zip(names, down, strict=False):
            place = _place(way, time_us, shift_us)
            found["unknown", name] = Fingertip(_on_screen(place, corners_mm, screen), 0.0, True)
        yield time_us, found


def _during(way: Way, time_us: int, shift_us: int) -> bool:
    return _us(way[0].time_s, shift_us) <= time_us <= _us(max(e.time_s for e in way), shift_us)


def _place(way: Way, time_us: int, shift_us: int) -> tuple[float, float]:
    """Return where a touch is: at its last event before that time. An end has no place."""
    moves = [event for event in way if event.kind != "touchend"]
    before = [event for event in moves if _us(event.time_s, shift_us) <= time_us]
    last = before[-1] if before else moves[0]
    return last.x, last.y


def _us(time_s: float, shift_us: int) -> int:
    return round(1e6 * time_s) + shift_us


def _on_screen(
    place: tuple[float, float], corners_mm: Points, screen: tuple[int, int]
) -> tuple[float, float, float]:
    """Return a point of the screen in the camera's frame, mm."""
    width, height = screen
    flat = np.array([[0, 0], [width, 0], [width, height], [0, height]], np.float32)
    # A point of a plane is linear in the screen's points, whatever its slant.
    matrix, *_ = np.linalg.lstsq(np.column_stack([flat, np.ones(4)]), corners_mm, rcond=None)
    x, y, z = np.array([*place, 1.0]) @ matrix
    return round(float(x), 2), round(float(y), 2), round(float(z), 2)


def _frames(source: Source) -> Iterator[Frame]:
    while True:
        try:
            capture = source.read(1.0)
        except EndOfSource:
            return
        if isinstance(capture, Frame):
            yield capture
