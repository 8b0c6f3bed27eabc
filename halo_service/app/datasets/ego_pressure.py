"""eth-siplab/EgoPressure: one sequence of a static camera to a recording and its truth.

Its files are Parquet shards as docs/DATA.md of its repository describes them. Depth is 512 x 512 of
an Azure Kinect (WFOV_2X2BINNED) and only within the colour image's view; colour is undistorted; the
pressure pad is the plane z = 0, z downwards, its cells 1.25 mm. There is **no infrared**: here the
colour's brightness, seen from the depth camera, is in its place.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from halo_service.app.datasets.truth_lines import Fingertip, Line, Who, frame_lines
from halo_service.errors import UserError
from halo_service.geometry import k4a
from halo_service.geometry.camera import Camera, Lens, Points
from halo_service.geometry.matrix import Matrix4
from halo_service.values import Frame

FPS = 30
PERIOD_US = 33_333
CELLS = (105, 185)
"""Rows and columns of the pad."""
CELL_MM = 1.25
PAD_MM = (240.0, 137.5)
"""Its active area, around the origin."""
COUNTS_PER_N = 1736.0
G_PER_N = 1000.0 / 9.80665
TIPS = {"thumb": 4, "index": 8, "middle": 12, "ring": 16, "little": 20}
"""The joints at the fingers' ends."""
REACH_MM = 15.0
"""A cell's force belongs to the nearest fingertip within this, else to none."""
LEAST_G = 10.0
"""From here on a finger touches: about twice the pad's noise over a fingertip (chosen)."""
MISSING = "import-dataset: pyarrow is not installed: uv sync --extra datasets"


@dataclass(frozen=True, slots=True)
class SequenceRequest:
    """Which sequence of a download, and which of its static cameras."""

    folder: Path
    participant: str
    sequence: str
    camera: int
    """1 to 7."""

    @property
    def shards(self) -> Path:
        """The folder of the shards."""
        return self.folder / "data" / self.participant / self.sequence

    @property
    def config(self) -> Path:
        """The sequence's calibration."""
        return self.folder / "configs" / self.participant / f"{self.sequence}.json"

    @property
    def factory(self) -> Path:
        """The camera's factory calibration."""
        name = f"cam-{self.camera}.k4a_calibration.json"
        return self.folder / "configs" / self.participant / f"{self.sequence}_k4a" / name


@dataclass(frozen=True, slots=True, eq=False)
class Rig:
    """The camera, and where the pad is."""

    camera: Camera
    depth_from_pad: Matrix4
    """mm: p_depth = M p_pad."""


def read_rig(request: SequenceRequest) -> Rig:
    """Read both calibrations. Raises UserError where they are missing or cannot be understood."""
    try:
        config = json.loads(request.config.read_text(encoding="utf-8"))
        factory = request.factory.read_bytes()
        entry = config["camera_calibrations"][str(request.camera)]
        size = int(entry["ImageSizeX"]), int(entry["ImageSizeY"])
        colour_from_pad = np.array(entry["ModelViewMatrix"], np.float64).reshape(4, 4)
        fx, fy, cx, cy = (float(entry[name]) for name in ("fx", "fy", "cx", "cy"))
        plain = Lens(*size, fx, fy, cx, cy)
        known = k4a.from_json(
            factory,
            depth_mode="WFOV_2X2BINNED",
            colour_resolution=k4a.colour_resolution_of(plain),
            fps=FPS,
        )
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise UserError(
            f"import-dataset: the calibration of camera {request.camera} cannot be read ({error}); "
            f"download {request.config} and {request.factory}"
        ) from error
    camera = replace(known, colour=plain)
    return Rig(camera, np.linalg.inv(camera.colour_from_depth) @ colour_from_pad)


def frames(request: SequenceRequest, rig: Rig) -> Iterator[Frame]:
    """Yield the frames; one that the camera dropped is absent."""
    colours = _rows(request.shards / f"cam-{request.camera}.color.parquet", ("frame", "image"))
    jpegs = {row["frame"]: row["image"]["bytes"] for row in colours}
    for row in _rows(request.shards / f"cam-{request.camera}.depth.parquet", ("frame", "depth")):
        depth = _image(row["depth"]["bytes"], cv2.IMREAD_UNCHANGED)
        shape = rig.camera.depth.height, rig.camera.depth.width
        if depth.shape != shape or depth.dtype != np.uint16:
            raise UserError(
                f"import-dataset: depth of frame {row['frame']} is {depth.dtype} {depth.shape}, "
                f"not uint16 {shape}"
            )
        jpeg = jpegs.get(row["frame"])
        yield Frame(
            row["frame"] * PERIOD_US,
            np.asarray(depth, np.uint16),
            brightness(depth, jpeg, rig.camera),
            jpeg,
        )


def brightness(depth: NDArray[Any], jpeg: bytes | None, camera: Camera) -> NDArray[np.uint16]:
    """(H, W) uint16: the colour's brightness where depth is measured, in place of infrared."""
    found = np.zeros(depth.shape, np.uint16)
    if jpeg is None or camera.colour is None:
        return found
    grey = _image(jpeg, cv2.IMREAD_GRAYSCALE)
    rows, columns = np.nonzero(depth)
    px = np.column_stack([columns, rows]).astype(np.float64)
    points = camera.depth.rays(px) * depth[rows, columns][:, None]
    moved = points @ camera.colour_from_depth[:3, :3].T + camera.colour_from_depth[:3, 3]
    u, v = np.rint(camera.colour.project(moved)).astype(int).T
    seen = (u >= 0) & (u < grey.shape[1]) & (v >= 0) & (v < grey.shape[0])
    found[rows[seen], columns[seen]] = grey[v[seen], u[seen]].astype(np.uint16) * 16
    return found


def truth(request: SequenceRequest, rig: Rig) -> list[Line]:
    """Return the truth's lines of all frames."""
    columns = ("frame", "has_annotation", "joint_position", "hand_side")
    hands = {row["frame"]: row for row in _rows(request.shards / "annotation.parquet", columns)}

    def lines() -> Iterator[tuple[int, Mapping[Who, Fingertip]]]:
        for row in _rows(request.shards / "pressure.parquet", ("frame", "force")):
            force = np.array(row["force"], np.float64).reshape(CELLS)
            yield row["frame"] * PERIOD_US, fingertips(force, hands.get(row["frame"]), rig)

    return list(frame_lines(lines()))


def fingertips(
    counts: NDArray[np.float64], hand: Mapping[str, Any] | None, rig: Rig
) -> dict[Who, Fingertip]:
    """Return the fingertips of one frame; none where the hand is not annotated."""
    if hand is None or not hand["has_annotation"]:
        return {}
    joints_mm = np.array(hand["joint_position"], np.float64).reshape(21, 3) * 1000.0
    tips_mm = joints_mm[list(TIPS.values())]
    grams = forces_g(counts, tips_mm)
    moved = tips_mm @ rig.depth_from_pad[:3, :3].T + rig.depth_from_pad[:3, 3]
    side = str(hand["hand_side"])
    return {
        (side, name): Fingertip(
            (round(float(x), 2), round(float(y), 2), round(float(z), 2)),
            round(max(float(-tip[2]), 0.0), 2),
            bool(force_g >= LEAST_G),
            round(float(force_g), 1),
        )
        for name, tip, (x, y, z), force_g in zip(TIPS, tips_mm, moved, grams, strict=True)
    }


def forces_g(counts: NDArray[np.float64], tips_mm: Points) -> NDArray[np.float64]:
    """(5,) grams under each fingertip. `counts`: (105, 185) of the pad."""
    rows, columns = np.nonzero(counts > 0.0)
    x = (columns + 0.5) / CELLS[1] * PAD_MM[0] - PAD_MM[0] / 2.0
    y = (rows + 0.5) / CELLS[0] * PAD_MM[1] - PAD_MM[1] / 2.0
    found = np.zeros(len(tips_mm))
    if len(rows) == 0:
        return found
    far = np.hypot(x[:, None] - tips_mm[:, 0], y[:, None] - tips_mm[:, 1])
    nearest = far.argmin(axis=1)
    near = far[np.arange(len(far)), nearest] <= REACH_MM
    np.add.at(found, nearest[near], counts[rows[near], columns[near]])
    return np.asarray(found / COUNTS_PER_N * G_PER_N, dtype=np.float64)


def _image(data: bytes, how: int) -> NDArray[Any]:
    image = cv2.imdecode(np.frombuffer(data, np.uint8), how)
    if image is None:
        raise UserError("import-dataset: an image of a shard cannot be decoded; download it again")
    return np.asarray(image)


def _rows(path: Path, columns: tuple[str, ...]) -> Iterator[dict[str, Any]]:
    """Yield the rows of a shard in the order of frames, one row group at a time."""
    try:
        from pyarrow import ArrowException
        from pyarrow.parquet import ParquetFile
    except ImportError as error:
        raise UserError(MISSING) from error
    try:
        with ParquetFile(path) as shard:
            for group in range(shard.num_row_groups):
                yield from shard.read_row_group(group, columns=list(columns)).to_pylist()
    except (OSError, ArrowException, KeyError) as error:
        raise UserError(
            f"import-dataset: {path} cannot be read ({error}); download it again"
        ) from error
