"""A drawn table: a flat surface, a finger above it, a dent around its tip.

For unit tests of the sensing only: it looks like nothing real, but each number in it is set here.
All lengths are mm on the surface. `VIEWS` shows the same table from other heights and through
another lens, because a length that is wrongly counted in pixels works in one of them only.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import cv2
import numpy as np
import pytest

from halo_service.geometry.camera import Camera, Lens
from halo_service.geometry.surface import Surface
from halo_service.profile import Background, Profile, TouchState, TouchStates
from halo_service.sensing import SensingSettings, start, step
from halo_service.values import Frame, Hand, Pointer, Side, Tracked

Pair = tuple[float, float]

FRAME_US = 33_333
RADIUS_MM, THICKNESS_MM = 8.0, 14.0
"""Of the drawn fingertip: half its breadth, and from pad to upper side."""
DENT_MM = (30.0, 8.0)
"""Breadth and length of the drawn dent, which lies ahead of the tip, where no finger is."""
DEPTHS_MM = {"hover": 9, "subtle": 10, "touch": 12, "pressure": 16}
"""Depth of the drawn dent in the four calibrated states."""
MIDDLE: Pair = (150.5, 100.5)
"""The middle of the surface, where a pixel of the plain view has its centre."""
PLAIN_SIGNALS = {"hover": 500.0, "subtle": 1500.0, "touch": 2000.0, "pressure": 3000.0}
PLAIN_PER_DENT = 240.0
"""Signal of a dent in the plain view, mm px a mm."""


@dataclass(frozen=True)
class DrawnTable:
    """A table of 300 x 200 mm, its middle on the optical axis, seen by a lens."""

    lens: Lens
    distance_mm: float
    surface_mm: Pair = (300.0, 200.0)

    @cached_property
    def surface(self) -> Surface:
        """Parallel to the image."""
        pose = np.eye(4)
        pose[:3, 3] = (-self.surface_mm[0] / 2.0, -self.surface_mm[1] / 2.0, self.distance_mm)
        return Surface("table", *self.surface_mm, pose)

    @cached_property
    def camera(self) -> Camera:
        """The lens with nothing else."""
        return Camera("DRAWN", "NFOV_UNBINNED", 30, self.lens, None, np.eye(4))

    @cached_property
    def profile(self) -> Profile:
        """Calibrated as this table's own dents read, in all four states."""
        per_dent = self.signal_per_dent
        return self._profile({name: per_dent * deep for name, deep in DEPTHS_MM.items()})

    @property
    def shape(self) -> tuple[int, int]:
        """Height and width of the image, px."""
        return self.lens.height, self.lens.width

    @property
    def px_per_mm(self) -> float:
        """On the surface."""
        return self.lens.fx / self.distance_mm

    def px(self, at_mm: Pair, height_mm: float = 0.0) -> Pair:
        """Return where a place above the surface is in the image."""
        x, y = self.lens.project(self.surface.to_camera(np.array([[*at_mm, -height_mm]])))[0]
        return float(x), float(y)

    @cached_property
    def empty(self) -> Frame:
        """The table without a hand."""
        depth = np.full(self.shape, self.distance_mm, np.uint16)
        return Frame(0, depth, np.full(self.shape, 1000, np.uint16))

    def frame(
        self, at_mm: Pair = MIDDLE, dent_mm: float = 0.0, height_mm: float = 0.0, time_us: int = 0
    ) -> Frame:
        """Draw a finger that points away from the user, the end of its outline over a place.

        `dent_mm`: depth of the dent; `height_mm`: of the pad.
        """
        middle_mm = height_mm + RADIUS_MM
        scale = self.lens.fx / (self.distance_mm - middle_mm)
        return self.painted(self.px(at_mm, middle_mm), scale, dent_mm, height_mm, time_us)

    def hands(self, at_mm: Pair = MIDDLE, time_us: int = 0, off_mm: Pair = (0.0, 0.0)) -> Tracked:
        """Return the tracker's view of the index finger of a right hand, that far off."""
        tip_px = self.px((at_mm[0] + off_mm[0], at_mm[1] + off_mm[1]))
        return pointing(tip_px, self.px_per_mm, time_us)

    @cached_property
    def signal_per_dent(self) -> float:
        """Signal that the sensing reads of a dent at a touching finger, mm px a mm."""
        depth_mm = DEPTHS_MM["touch"]
        state = start(self._profile(PLAIN_SIGNALS), SensingSettings())
        middle_mm = (self.surface_mm[0] / 2.0 + 0.5, self.surface_mm[1] / 2.0 + 0.5)
        frame, _ = step(state, self.frame(middle_mm, depth_mm), self.hands(middle_mm))
        return frame.pointers[0].diagnostics.halo / depth_mm

    def off_mm(self, pointer: Pointer, at_mm: Pair, height_mm: float = 0.0) -> Pair:
        """Return how far a pointer's outline ends from a place, x and y."""
        there = self.px(at_mm, height_mm + RADIUS_MM)
        tip, scale = pointer.diagnostics.tip_px, self.px_per_mm
        return (tip[0] - there[0]) / scale, (tip[1] - there[1]) / scale

    def painted(
        self, tip_px: Pair, px_per_mm: float, dent_mm: float, height_mm: float, time_us: int
    ) -> Frame:
        """Draw a finger; its outline ends at a pixel; 1 mm is `px_per_mm` there."""
        depth = self.empty.depth.copy()
        x, y = round(tip_px[0]), round(tip_px[1])
        radius = round(RADIUS_MM * px_per_mm)
        if dent_mm > 0.0:
            half, long = (round(each * px_per_mm) for each in (DENT_MM[0] / 2.0, DENT_MM[1]))
            rows, columns = (
                slice(max(y - long, 0), max(y, 0)),
                slice(max(x - half, 0), max(x + half, 0)),
            )
            depth[rows, columns] = round(self.distance_mm + dent_mm)
        top = round(self.distance_mm - THICKNESS_MM - height_mm)
        end = (x, y + radius)
        cv2.line(depth, end, (x, end[1] + round(80.0 * px_per_mm)), top, thickness=2 * radius)
        cv2.circle(depth, end, radius, top, thickness=-1)
        return Frame(time_us, depth, self.empty.ir)

    def _profile(self, signals: dict[str, float]) -> Profile:
        background = Background(
            np.full(self.shape, self.distance_mm, np.float32),
            np.ones(self.shape, np.float32),
            np.ones(self.shape, bool),
        )
        states = TouchStates(
            hover=TouchState(signals["hover"], 10.0, 0.0),
            subtle=TouchState(signals["subtle"], 1.0, 0.0),
            touch=TouchState(signals["touch"], 0.0, 25.0),
            pressure=TouchState(signals["pressure"], 0.0, 200.0),
            line_px_at_hover=6.0,
            finger_thickness_mm=THICKNESS_MM,
        )
        return Profile("drawn", self.camera, self.surface, background, states, 1)


def pointing(tip_px: Pair, px_per_mm: float, time_us: int) -> Tracked:
    """Return a right hand whose index finger points up the image to a pixel."""
    back_mm = np.full(21, 150.0)
    back_mm[5:9] = [90.0, 60.0, 30.0, 6.0]
    landmarks = np.column_stack([np.full(21, tip_px[0]), tip_px[1] + px_per_mm * back_mm])
    return Tracked(time_us, (Hand(Side.RIGHT, landmarks, 0.9),))


PINHOLE = Lens(640, 576, 500.0, 500.0, 319.5, 287.5)
WIDE = Lens(
    512, 512, 252.0, 252.3, 258.4, 253.7, (0.5, -0.02, 1e-5, -7e-5, -0.003, 0.9, 0.09, -0.01)
)
"""Like a Kinect's wide field of view, binned: half as many pixels a mm, and distorted."""
PLAIN = DrawnTable(PINHOLE, 500.0)
"""1 px is 1 mm."""
VIEWS = {
    "500 mm": PLAIN,
    "350 mm": DrawnTable(PINHOLE, 350.0),
    "900 mm": DrawnTable(PINHOLE, 900.0),
    "wide lens": DrawnTable(WIDE, 500.0),
}


@pytest.fixture(scope="session", params=VIEWS.values(), ids=VIEWS)
def table(request: pytest.FixtureRequest) -> DrawnTable:
    """The drawn table in each of the views."""
    view: DrawnTable = request.param
    return view


@pytest.fixture(scope="session")
def camera() -> Camera:
    """A plain pinhole: 1 px is 1 mm at 500 mm."""
    return PLAIN.camera


@pytest.fixture(scope="session")
def profile() -> Profile:
    """Of the plain view; the four states at 500, 1500, 2000 and 3000 mm px."""
    return PLAIN._profile(PLAIN_SIGNALS)


@pytest.fixture(scope="session")
def draw() -> Callable[..., Frame]:
    """Draw the plain view: the outline of a finger ends at `tip`, px; `signal`: mm px."""

    def drawn(
        tip: Pair = (320.0, 288.0), signal: float = 0.0, height_mm: float = 0.0, time_us: int = 0
    ) -> Frame:
        return PLAIN.painted(tip, 1.0, signal / PLAIN_PER_DENT, height_mm, time_us)

    return drawn


@pytest.fixture(scope="session")
def see() -> Callable[..., Tracked]:
    """A tracker that sees the index finger of a right hand in the plain view, px."""

    def seen(tip: Pair = (320.0, 288.0), time_us: int = 0, off: Pair = (0.0, 0.0)) -> Tracked:
        return pointing((tip[0] + off[0], tip[1] + off[1]), 1.0, time_us)

    return seen
