"""The virtual user: a source with a finger that follows the prompts of the calibration.

It makes a calibration possible without a camera. It follows the same prompts that a person reads.
Frames come as fast as they can be rendered; their time stamps are simulated.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray

from halo_calibration.boards.board import Printed, marker_squares
from halo_calibration.guided.guide import Prompt
from halo_calibration.solvers.touch import StateValues
from halo_service.values import Frame, SourceKind
from halo_service.virtual.bodies import wedge
from halo_service.virtual.hand import pointing
from halo_service.virtual.motion import Segment, Timeline
from halo_service.virtual.props import Flat, printed
from halo_service.virtual.room import HEIGHT_MM, WIDTH_MM, Room
from halo_service.virtual.scenarios.common import away, is_away
from halo_service.virtual.sensor import Sensor
from halo_service.virtual.skeleton import FingerPose, PosedHand, posed
from halo_service.virtual.timeline import TimelineReader

HOVER_MM, SUBTLE_MM = 10.0, 1.0
TOUCH_G, PRESSURE_G, HARD_G = 25.0, 200.0, 400.0
"""Heights of the spacers and forces on the scale (the heights are the paper's, 4.3.5)."""
STATE_VALUES = StateValues(HOVER_MM, SUBTLE_MM, TOUCH_G, PRESSURE_G)
STATES = {
    "hover": (HOVER_MM, 0.0),
    "subtle": (SUBTLE_MM, 0.0),
    "touch": (0.0, TOUCH_G),
    "pressure": (0.0, PRESSURE_G),
    "hard": (0.0, HARD_G),
}
MOVE_S = 0.8
"""Time from one state to the next: less than the count-down."""
WAIT_S = 0.1
"""Time between two looks for a new prompt."""
EDGE_MM = 20.0
"""Distance of the sweep from the edges."""
ROWS = 6
ROW_S = 2.8
"""Rows of a sweep, and the time for each: together a little less than the whole sweep."""
TURN_DEG = 25.0
"""How far the finger turns to both sides during the sweep."""
REST_S, TAP_S = 0.7, 0.12
"""Time that the finger rests on a mark, and of a tap."""
AIM_MM = 0.5
"""Error of the touches on a mark, one sigma in x and y; chosen: a pen reaches 0.5 mm, and a finger
hides the mark."""
AREA = ((22.0, 14.0), (276.0, 24.0), (270.3, 173.9), (16.3, 163.9))
"""The corners of the area that the user touches, far left first: 254 x 150 mm, slightly rotated; mm
on the surface."""
SHEET_AT = (155.0, 96.0, 3.0)
"""Position of the surface sheet: its middle in mm, and its rotation in degrees."""
MARKER_AT = (215.0, 60.0, -24.0)
"""The same for the marker of an anchor."""
DOTS_PER_MM = 8
"""Resolution of the printed sheets: 203 dots per inch."""
EMPTY_HANDED = ("background", "sheet", "marker", "board", "away")
"""Prompts that need no hand."""


class VirtualUser:
    """A `Source`: the virtual camera above a user who follows prompts."""

    kind: Final[SourceKind] = "virtual"

    def __init__(self, room: Room, *, colour_times: int = 2) -> None:
        """`colour_times`: see `Sensor`."""
        # The seat of an installation is on the canvas; this user sits in the camera's own frame.
        room = replace(room, seat_deg=room.seat_deg - room.place.angle_deg)
        self._room = room
        self._sensor = Sensor(room, colour_times=colour_times)
        self.camera = self._sensor.camera
        rng = np.random.default_rng([room.seed, 5])
        self._performer = Timeline(rng, away(room, room.dominant), room.dominant)
        self._track = TimelineReader(self._live(), rng, room.seat_deg)
        self._prompt: Prompt | None = None
        self._index = 0

    def follow(self, prompt: Prompt) -> None:
        """Follow a prompt, from the next frame on."""
        self._prompt = prompt
        if prompt.name in EMPTY_HANDED:  # a sheet stays on the table during touches
            self._furnish(sheets=() if prompt.board is None else (_on_table(prompt.board),))

    def expose(self, exposure_ms: float | None) -> None:
        """Set the exposure of the colour camera; None: automatic."""
        self._furnish(exposure_ms=exposure_ms)

    @property
    def projector_px(self) -> tuple[int, int]:
        """Width and height of the picture of the projector."""
        return self._room.projector.width_px, self._room.projector.height_px

    def project(self, picture: NDArray[np.uint8]) -> None:
        """Show a (height, width, 3) BGR picture with the virtual projector."""
        self._sensor.show(picture)

    def _furnish(self, **changes: object) -> None:
        room = replace(self._room, **changes)  # type: ignore[arg-type]
        if (room.sheets, room.exposure_ms) != (self._room.sheets, self._room.exposure_ms):
            self._room = room
            self._sensor.furnish(room)

    def skip(self, seconds: float) -> None:
        """Let time pass without a frame."""
        until = self._index + round(seconds * self.camera.fps)
        while self._index < until:  # step by step: a prompt is read when the one before is done
            self._track.at(self._index / self.camera.fps)
            self._index += 1

    def read(self, timeout_s: float) -> Frame:
        """Return the next frame."""
        del timeout_s  # it never has to wait
        t_s = self._index / self.camera.fps
        self._index += 1
        aim = self._track.at(t_s)
        rests = self._track.tool_at(t_s) == "wedge"
        things = [wedge(aim.x_mm, aim.y_mm, aim.yaw_deg)] if rests else []
        return self._sensor.frame(round(t_s * 1e6), self._hands(aim), things)

    def close(self) -> None:
        """Do nothing: there is nothing to close."""

    def _hands(self, aim: FingerPose) -> list[PosedHand]:
        """Return the hand if it is in view; one outside need not be rendered."""
        user, side = self._room.user, self._room.dominant
        if is_away(self._room, aim):
            return []
        return [posed(user, pointing(user, side, aim, curl=1.0))]

    def _live(self) -> Iterator[Segment]:
        while True:
            prompt, self._prompt = self._prompt, None
            if prompt is None:
                yield from self._stay()
            elif prompt.name in EMPTY_HANDED:
                yield from self._go(away(self._room, self._room.dominant))
            elif prompt.name == "corner":
                yield from self._touch(*AREA[prompt.number])
            elif prompt.name == "cross":
                yield from self._touch(*self._under(prompt.at_px))
            elif prompt.name in ("spot", "tap"):
                rest_s = REST_S if prompt.name == "spot" else TAP_S
                yield from self._touch(*prompt.at_mm, rest_s)
            elif prompt.name == "level":
                yield from self._hold(prompt.height_mm, prompt.force_g)
            elif prompt.name in STATES:
                yield from self._hold(*STATES[prompt.name])
            else:
                yield from self._sweep(prompt.pitch_deg)

    def _stay(self) -> Iterator[Segment]:
        """Continue for a moment: a pressed finger stays pressed."""
        force_g, here = self._performer.pose.force_g, self._performer.pose
        if force_g > 0.0:
            yield from self._performer.press(WAIT_S, lambda _: force_g)
            self._performer.pose = here
        else:
            yield from self._performer.hold(WAIT_S)

    def _go(self, home: FingerPose) -> Iterator[Segment]:
        self._performer.tool = None
        yield from self._performer.reach(
            MOVE_S, 20.0, x_mm=home.x_mm, y_mm=home.y_mm, height_mm=home.height_mm
        )

    def _hold(self, height_mm: float, force_g: float) -> Iterator[Segment]:
        p = self._performer
        p.tool = None
        middle = {"x_mm": WIDTH_MM / 2.0, "y_mm": HEIGHT_MM / 2.0, "pitch_deg": 45.0}
        yield from p.reach(MOVE_S, 10.0, **middle, yaw_deg=0.0, height_mm=max(height_mm, 8.0))
        if force_g == 0.0:
            yield from p.reach(MOVE_S / 2.0, height_mm=height_mm)
            return
        yield from p.strike(MOVE_S / 2.0)
        p.pose = FingerPose(WIDTH_MM / 2.0, HEIGHT_MM / 2.0, 0.0, force_g, 45.0, 0.0)

    def _under(self, px: tuple[float, float]) -> tuple[float, float]:
        """Return where a pixel of the projector is on the table, mm."""
        back = np.linalg.inv(self._room.projector.projector_from_surface())
        x, y, w = back @ (*px, 1.0)
        return float(x / w), float(y / w)

    def _touch(self, x_mm: float, y_mm: float, rest_s: float = REST_S) -> Iterator[Segment]:
        """Touch a mark again and again, until the next prompt."""
        p = self._performer
        p.tool = None
        lift = {"height_mm": 40.0, "pitch_deg": 45.0, "yaw_deg": 0.0}
        yield from p.reach(MOVE_S, 20.0, x_mm=x_mm, y_mm=y_mm, **lift)
        while self._prompt is None:
            dx, dy = p.rng.normal(0.0, AIM_MM, 2)
            yield from p.reach(0.3, x_mm=x_mm + dx, y_mm=y_mm + dy, height_mm=12.0)
            yield from p.strike(0.1)
            yield from p.press(rest_s, lambda _: TOUCH_G)
            yield from p.reach(0.4, height_mm=40.0)

    def _sweep(self, pitch_deg: float) -> Iterator[Segment]:
        p = self._performer
        p.tool = "wedge" if pitch_deg == 45.0 else None
        left, right = EDGE_MM, WIDTH_MM - EDGE_MM
        yield from p.reach(1.2, 10.0, x_mm=left, y_mm=EDGE_MM, height_mm=10.0, pitch_deg=pitch_deg)
        yield from p.strike(0.4)
        phase = p.rng.uniform(0.0, 2.0 * np.pi)
        for row in range(ROWS):
            y = EDGE_MM + (HEIGHT_MM - 2.0 * EDGE_MM) * row / (ROWS - 1)
            start, end = (left, right) if row % 2 == 0 else (right, left)
            yield from self._stroke((start, end), y, pitch_deg, phase + row)
        p.pose = FingerPose(p.pose.x_mm, p.pose.y_mm, 0.0, TOUCH_G, pitch_deg, 0.0)

    def _stroke(
        self, x_mm: tuple[float, float], y_mm: float, pitch_deg: float, phase: float
    ) -> Iterator[Segment]:
        """Move the finger along one row and to the next."""
        step = (HEIGHT_MM - 2.0 * EDGE_MM) / (ROWS - 1)
        slack = self._performer.rng.uniform(-1.5, 1.5)

        def slide(s: float) -> dict[str, float]:
            return {
                "x_mm": x_mm[0] + (x_mm[1] - x_mm[0]) * min(1.0, s / 0.9),
                "y_mm": min(y_mm + step * max(0.0, (s - 0.9) / 0.1), HEIGHT_MM - EDGE_MM),
                "pitch_deg": pitch_deg + slack,
                "yaw_deg": TURN_DEG * float(np.sin(2.0 * np.pi * s + phase)),
            }

        yield from self._performer.press(ROW_S, lambda _: TOUCH_G, slide)


def _on_table(board: Printed) -> Flat:
    """Print a board, and put it on the table."""
    half = board.size_mm / 2.0
    middles = np.array(list(board.middles_mm.values()))
    edge = 2.0 * board.size_mm / board.family.modules  # a marker includes the white around it
    corner = middles.min(axis=0) - half - edge
    width_mm, height_mm = middles.max(axis=0) + half + edge - corner
    sheet = np.full((round(height_mm * DOTS_PER_MM), round(width_mm * DOTS_PER_MM)), 255, np.uint8)
    side = round(board.size_mm * DOTS_PER_MM)
    for number, middle in board.middles_mm.items():
        squares = np.where(marker_squares(board.family, number), 0, 255).astype(np.uint8)
        x, y = np.rint((np.array(middle) - half - corner) * DOTS_PER_MM).astype(int)
        size = (side, side)
        sheet[y : y + side, x : x + side] = cv2.resize(
            squares, size, interpolation=cv2.INTER_NEAREST
        )
    x_mm, y_mm, turn_deg = SHEET_AT if len(middles) > 1 else MARKER_AT
    return printed(sheet, x_mm, y_mm, float(width_mm), turn_deg)
