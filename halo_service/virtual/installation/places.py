"""Where the cameras of an installation are: their areas on one canvas.

Rule: a seed and the number of cameras give all places, so each process computes the same ones. The
canvas has the frame of camera 1's area: its (0, 0), x to the right, y towards the user, mm.
"""

from __future__ import annotations

import zlib
from dataclasses import dataclass

import numpy as np

from halo_service.errors import UserError
from halo_service.geometry.k4a import DEPTH_FPS
from halo_service.virtual.mesh import Floats

AREA_MM = (300.0, 200.0)
"""One camera's area, width and height: the paper's interaction area at 0.5 m (6.4)."""
STEP_MM = (240.0, 140.0)
"""From one area to the next, to the right and towards the user: neighbours overlap by 60 mm. That
is room for a fingertip, the errors of two cameras and a change from one to the other; chosen."""
COLUMNS = {1: 1, 2: 2, 3: 3, 4: 2, 5: 5, 6: 3}
"""Cameras -> areas in a row: four are 2 x 2, six are 3 x 2, the others one row."""
OFF_MM, OFF_DEG = 4.0, 2.5
"""How far a camera is from where it should be, at most: no bracket is exact; chosen."""
SYNCS = ("wired", "none")
FRAME_US = 1e6 // max(DEPTH_FPS.values())
"""Of the fastest depth modes."""


@dataclass(frozen=True, slots=True)
class Installation:
    """Which camera this is, of how many. The default is one camera on its own."""

    cameras: int = 1
    camera: int = 1
    """1 is at the far left, 2 to the right of it; the second row is nearer to the user."""
    sync: str = "wired"
    """`wired`: all expose by one clock, one after the other; `none`: each by its own."""
    delay_us: float = 160.0
    """With `wired`: how much later each camera exposes than the one before it. 160 us or more
    avoids interference (Azure Kinect DK, "Synchronize multiple devices")."""
    angles_deg: tuple[float, ...] = ()
    """How far each camera is turned, clockwise as seen from above; empty: the seed decides."""

    @property
    def alone(self) -> bool:
        """Whether there is no other camera."""
        return self.cameras == 1

    @property
    def numbers(self) -> range:
        """The numbers of all cameras."""
        return range(1, self.cameras + 1)


@dataclass(frozen=True, slots=True)
class Place:
    """One camera's area on the canvas."""

    x_mm: float
    y_mm: float
    """Where its (0, 0) is."""
    angle_deg: float
    """Direction of its x axis, clockwise as seen from above."""

    @property
    def canvas_from_surface(self) -> Floats:
        """(4, 4) rotation and translation, mm."""
        angle = np.radians(self.angle_deg)
        matrix = np.eye(4)
        matrix[:2, :2] = [[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]]
        matrix[:2, 3] = self.x_mm, self.y_mm
        return matrix

    @property
    def middle_mm(self) -> Floats:
        """(2,) the middle of the area on the canvas."""
        half = np.array([AREA_MM[0] / 2.0, AREA_MM[1] / 2.0, 0.0, 1.0])
        return np.asarray((self.canvas_from_surface @ half)[:2], dtype=np.float64)


def place_of(installation: Installation, seed: int, number: int) -> Place:
    """Where camera `number` is; camera 1 gives the canvas its frame unless it is turned by name."""
    row, column = divmod(number - 1, COLUMNS[installation.cameras])
    dx, dy, angle = 0.0, 0.0, 0.0
    if number > 1:
        draw = np.random.default_rng([seed, zlib.crc32(b"place"), number])
        dx, dy = draw.uniform(-OFF_MM, OFF_MM, 2).tolist()
        angle = float(draw.uniform(-OFF_DEG, OFF_DEG))
    if installation.angles_deg:
        angle = installation.angles_deg[number - 1]
    middle = np.array([STEP_MM[0] * column + dx, STEP_MM[1] * row + dy]) + np.array(AREA_MM) / 2.0
    corner = middle - Place(0.0, 0.0, angle).middle_mm
    return Place(float(corner[0]), float(corner[1]), angle)


def canvas_mm(installation: Installation) -> tuple[float, float]:
    """Width and height of the canvas."""
    columns = COLUMNS[installation.cameras]
    rows = installation.cameras // columns
    return (
        AREA_MM[0] + STEP_MM[0] * (columns - 1),
        AREA_MM[1] + STEP_MM[1] * (rows - 1),
    )


def seams_mm(installation: Installation) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """The middles of the overlaps: x of those between columns, y of those between rows."""
    columns = COLUMNS[installation.cameras]
    counts = columns, installation.cameras // columns
    across, along = (
        tuple(step * number + (area - step) / 2.0 for number in range(1, count))
        for step, area, count in zip(STEP_MM, AREA_MM, counts, strict=True)
    )
    return across, along


def check(installation: Installation) -> None:
    """Raise UserError for numbers that do not fit together."""
    if installation.cameras not in COLUMNS:
        raise UserError(
            f"The virtual installation has {installation.cameras} cameras; "
            f"give {min(COLUMNS)} to {max(COLUMNS)}."
        )
    if installation.camera not in installation.numbers:
        raise UserError(
            f"The virtual camera's number is {installation.camera}; "
            f"give 1 to {installation.cameras}, or more cameras."
        )
    if installation.sync not in SYNCS:
        raise UserError(
            f"The virtual camera has no sync {installation.sync!r}; choose from: "
            f"{', '.join(SYNCS)}."
        )
    if not 0.0 <= installation.delay_us <= FRAME_US:
        raise UserError(
            f"The virtual camera's delay_us is {installation.delay_us:g}; "
            f"give 0 to {FRAME_US:.0f}, one frame."
        )
    if len(installation.angles_deg) not in (0, installation.cameras):
        raise UserError(
            f"The virtual installation has {len(installation.angles_deg)} angles_deg for "
            f"{installation.cameras} cameras; give one for each, e.g. angles_deg=0,180."
        )
