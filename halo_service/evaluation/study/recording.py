"""A stored recording: the hands that the tracker found, and the depth around them.

Simulating a frame and tracking its hands costs 30 ms, sensing it 2 ms. So both are done once, and
every method reads the same frames. A frame is stored as a window around everything that is not the
empty surface; outside there is only noise, restored as the background plus the device's drift. The
sensing reads no colour, so none is stored.
"""

from __future__ import annotations

import json
import zipfile
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from halo_service.files import appearing
from halo_service.geometry.camera import Camera
from halo_service.geometry.surface import Surface
from halo_service.profile import Background
from halo_service.sensing.background import DRIFT_GRID
from halo_service.values import Depth, Frame, Hand, Side, Tracked

Line = dict[str, Any]
"""One line of a truth or script file."""

AROUND_MM = 60.0
"""Depth is stored up to this far around the surface."""
MARGIN_PX = 28
"""Around what is above the surface: a halo's reach and a fast finger's."""
ABOVE_MM = 4.0
"""A pixel this much nearer than the background is above the surface."""
LEAST_PX = 3
"""Fewer such pixels in a row or column are noise."""
SURFACE_MM = 15.0
"""Pixels within this of the background show the device's drift."""
LATTICE: tuple[slice, slice] = DRIFT_GRID
"""Pixels that are stored everywhere: the sensing reads the drift from them."""

Box = tuple[int, int, int, int]
"""left, top, right, bottom, px; right and bottom outside."""


@dataclass(frozen=True, slots=True, eq=False)
class StoredFrame:
    """One frame, reduced to what the sensing needs."""

    time_us: int
    box: Box
    png: bytes
    """The depth inside the box."""
    infrared_png: bytes
    """The infrared inside the box."""
    lattice: Depth
    """The depth of the pixels of `LATTICE`."""
    hands: tuple[Hand, ...]
    """What the tracker found in this very frame."""
    image_hands: tuple[Hand, ...] = ()
    """What it finds in the whole blended image, as the paper's method does."""


@dataclass(frozen=True, slots=True, eq=False)
class StoredRecording:
    """One recording with its truth and script."""

    frames: tuple[StoredFrame, ...]
    truth: tuple[Line, ...]
    script: tuple[Line, ...]


def store(
    frame: Frame,
    tracked: Tracked,
    background: Background,
    reach: Box,
    image_hands: tuple[Hand, ...] = (),
) -> StoredFrame:
    """Reduce a frame. `reach`: where anything may be, px; `image_hands`: see `StoredFrame`."""
    left, top, right, bottom = reach
    part = slice(top, bottom), slice(left, right)
    depth, empty = frame.depth[part], background.mean_mm[part]
    above = (depth - empty < -ABOVE_MM) & (depth > 0) & background.valid[part]
    hands = (*tracked.hands, *image_hands)
    box = _window(above, hands, reach, frame.depth.shape)
    return replace(_stored(frame, tracked, box), image_hands=image_hands)


def store_whole(frame: Frame, tracked: Tracked) -> StoredFrame:
    """Store every pixel: a background is computed from such frames."""
    height, width = frame.depth.shape
    return _stored(frame, tracked, (0, 0, width, height))


def restore(
    stored: StoredFrame, background: Background, whole_image: bool = False
) -> tuple[Frame, Tracked]:
    """Return the frame and what the tracker found in it, or in its whole image."""
    surface = np.rint(background.mean_mm + _drift_mm(stored.lattice, background))
    depth = np.where(background.valid, surface, np.float32(0.0)).astype(np.uint16)
    depth[LATTICE] = stored.lattice
    infrared = np.zeros_like(depth)
    if background.infrared is not None:
        np.rint(background.infrared, out=infrared, casting="unsafe")
    left, top, right, bottom = stored.box
    if right > left and bottom > top:
        data = np.frombuffer(stored.png, np.uint8)
        depth[top:bottom, left:right] = cv2.imdecode(data, cv2.IMREAD_UNCHANGED)
        data = np.frombuffer(stored.infrared_png, np.uint8)
        infrared[top:bottom, left:right] = cv2.imdecode(data, cv2.IMREAD_UNCHANGED)
    hands = stored.image_hands if whole_image else stored.hands
    return Frame(stored.time_us, depth, infrared), Tracked(stored.time_us, hands)


def reach_box(surface: Surface, camera: Camera) -> Box:
    """Return the part of the image in which anything near the surface can be, px."""
    x = np.array([-AROUND_MM, surface.width_mm + AROUND_MM])
    y = np.array([-AROUND_MM, surface.height_mm + AROUND_MM])
    corners = np.array([(a, b, 0.0) for a in x for b in y])
    px = camera.depth.project(surface.to_camera(corners))
    low, high = np.floor(px.min(axis=0)), np.ceil(px.max(axis=0))
    return _clipped(low[0], low[1], high[0], high[1], (camera.depth.height, camera.depth.width))


def save(path: Path, recording: StoredRecording, key: str) -> None:
    """Write a recording, whole or not at all. `key`: names all that it depends on."""
    frames = recording.frames
    hands = [
        (index, whole_image, hand)
        for index, each in enumerate(frames)
        for whole_image, found in ((False, each.hands), (True, each.image_hands))
        for hand in found
    ]
    landmarks = [hand.landmarks_px for _, _, hand in hands]
    ends = np.cumsum([len(each.png) for each in frames], dtype=np.int64)
    infrared_ends = np.cumsum([len(each.infrared_png) for each in frames], dtype=np.int64)
    path.parent.mkdir(parents=True, exist_ok=True)
    with appearing(path) as file:
        np.savez(
            file,
            time_us=np.array([each.time_us for each in frames], np.int64),
            box=np.array([each.box for each in frames], np.int32).reshape(-1, 4),
            lattice=np.array([each.lattice for each in frames], np.uint16),
            png=np.frombuffer(b"".join(each.png for each in frames), np.uint8),
            png_end=ends,
            infrared_png=np.frombuffer(b"".join(each.infrared_png for each in frames), np.uint8),
            infrared_png_end=infrared_ends,
            hand_frame=np.array([index for index, _, _ in hands], np.int64),
            hand_whole_image=np.array([whole for _, whole, _ in hands], np.bool_),
            hand_side=np.array([int(hand.side) for _, _, hand in hands], np.int64),
            hand_confidence=np.array([hand.confidence for _, _, hand in hands], np.float64),
            hand_px=np.array(landmarks, np.float32).reshape(-1, 21, 2),
            key=np.array(key),
            lines=np.frombuffer(json.dumps([recording.truth, recording.script]).encode(), np.uint8),
        )


def read_key(path: Path) -> str:
    """Return a recording's key. Raises OSError without a file, ValueError for a damaged one."""
    try:
        with path.open("rb") as bytes_, np.load(bytes_, allow_pickle=False) as file:
            return str(file["key"])
    except (zipfile.BadZipFile, EOFError, KeyError) as error:
        raise ValueError(f"{path} is no recording ({error})") from error


def load(path: Path) -> StoredRecording:
    """Read a recording; raises OSError or ValueError for a file that is none."""
    with np.load(path, allow_pickle=False) as file:
        data = {name: file[name] for name in file.files}
    by_frame: dict[tuple[int, bool], list[Hand]] = {}
    for index, whole_image, side, sure, px in zip(
        data["hand_frame"].tolist(),
        data["hand_whole_image"].tolist(),
        data["hand_side"].tolist(),
        data["hand_confidence"].tolist(),
        data["hand_px"].astype(np.float64),
        strict=True,
    ):
        by_frame.setdefault((index, whole_image), []).append(Hand(Side(side), px, sure))
    depths = _split(data["png"], data["png_end"])
    infrareds = _split(data["infrared_png"], data["infrared_png_end"])
    frames = tuple(
        StoredFrame(
            time_us,
            tuple(box),
            depth,
            infrared,
            lattice,
            tuple(by_frame.get((index, False), ())),
            tuple(by_frame.get((index, True), ())),
        )
        for index, (time_us, box, lattice, depth, infrared) in enumerate(
            zip(
                data["time_us"].tolist(),
                data["box"].tolist(),
                data["lattice"],
                depths,
                infrareds,
                strict=True,
            )
        )
    )
    truth, script = json.loads(data["lines"].tobytes())
    return StoredRecording(frames, tuple(truth), tuple(script))


def restored(
    recording: StoredRecording, background: Background, whole_image: bool = False
) -> Iterator[tuple[Frame, Tracked]]:
    """Yield each frame with what the tracker found in it, or in its whole image."""
    return (restore(stored, background, whole_image) for stored in recording.frames)


def _stored(frame: Frame, tracked: Tracked, box: Box) -> StoredFrame:
    lattice = frame.depth[LATTICE].copy()  # a view would hold the whole frame in memory
    depth, infrared = _png(frame.depth, box), _png(frame.ir, box)
    return StoredFrame(frame.time_us, box, depth, infrared, lattice, tracked.hands)


def _split(joined: NDArray[np.uint8], ends: NDArray[np.int64]) -> list[bytes]:
    """Return the pieces of joined bytes, each up to its end."""
    whole, stops = joined.tobytes(), ends.tolist()
    return [whole[start:stop] for start, stop in zip([0, *stops[:-1]], stops, strict=True)]


def _drift_mm(lattice: Depth, background: Background) -> np.float32:
    """Return how much farther the device read than the background."""
    off_mm = lattice - background.mean_mm[LATTICE]
    surface = off_mm[(lattice > 0) & background.valid[LATTICE] & (np.abs(off_mm) < SURFACE_MM)]
    return np.float32(np.median(surface)) if surface.size else np.float32(0.0)


def _window(
    above: NDArray[np.bool_], hands: Sequence[Hand], reach: Box, shape: Sequence[int]
) -> Box:
    """Return the box around everything above the surface and around the fingertips.

    `above`: of the pixels in reach; `shape`: of the image.
    """
    left, top, right, bottom = reach
    columns = np.flatnonzero(np.count_nonzero(above, axis=0) >= LEAST_PX)
    rows = np.flatnonzero(np.count_nonzero(above, axis=1) >= LEAST_PX)
    corners: list[tuple[float, float]] = []
    if columns.size and rows.size:
        corners += [(left + columns[0], top + rows[0]), (left + columns[-1], top + rows[-1])]
    for hand in hands:
        for x, y in hand.landmarks_px[[4, 8, 12, 16, 20]].tolist():
            if left <= x < right and top <= y < bottom:
                corners.append((x, y))
    if not corners:
        return (0, 0, 0, 0)
    xs, ys = zip(*corners, strict=True)
    return _clipped(
        min(xs) - MARGIN_PX, min(ys) - MARGIN_PX, max(xs) + MARGIN_PX, max(ys) + MARGIN_PX,
        shape,
    )  # fmt: skip


def _clipped(left: float, top: float, right: float, bottom: float, shape: Sequence[int]) -> Box:
    height, width = shape[0], shape[1]
    return (
        min(max(int(left), 0), width),
        min(max(int(top), 0), height),
        min(max(int(right) + 1, 0), width),
        min(max(int(bottom) + 1, 0), height),
    )


def _png(image: NDArray[np.uint16], box: Box) -> bytes:
    left, top, right, bottom = box
    if right <= left or bottom <= top:
        return b""
    done, data = cv2.imencode(
        ".png", image[top:bottom, left:right], [cv2.IMWRITE_PNG_COMPRESSION, 1]
    )
    assert done  # a 16-bit grey image always can
    return data.tobytes()
