"""The person at the virtual table: a source whose finger does what the calibration says.

Without it nobody would follow the prompts where there is no camera. It is moved by the same cues
that a person reads; frames come as fast as they can be drawn, and time is their own.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

import numpy as np

from halo_calibration.guided import Cue
from halo_calibration.touch import Stated
from halo_service.values import Frame, SourceKind
from halo_service.virtual.bodies import wedge
from halo_service.virtual.camera import FPS
from halo_service.virtual.hand import pointing
from halo_service.virtual.motion import Performer, Segment
from halo_service.virtual.plays.common import away
from halo_service.virtual.room import HEIGHT_MM, WIDTH_MM, Room
from halo_service.virtual.sensor import Sensor
from halo_service.virtual.skeleton import FingerPose, posed
from halo_service.virtual.track import Track

HOVER_MM, SUBTLE_MM = 10.0, 1.0
TOUCH_G, PRESSURE_G = 25.0, 200.0
"""What this person's spacers and kitchen scale say (the heights are the paper's, 4.3.5)."""
STATED = Stated(HOVER_MM, SUBTLE_MM, TOUCH_G, PRESSURE_G)
STATES = {
    "hover": (HOVER_MM, 0.0),
    "subtle": (SUBTLE_MM, 0.0),
    "touch": (0.0, TOUCH_G),
    "pressure": (0.0, PRESSURE_G),
}
MOVE_S = 0.8
"""From one state to the next: well within the count-down."""
WAIT_S = 0.1
"""How often this person looks whether there is something new to do."""
EDGE_MM = 20.0
"""How near to the edges the sweep goes."""
ROWS = 6
ROW_S = 2.8
"""Rows of a sweep, and how long each takes: somewhat less than the whole sweep, then back."""
TURN_DEG = 25.0
"""How far the finger is turned to both sides meanwhile."""


class VirtualUser:
    """A `Source`: the virtual sensor over a person who follows cues."""

    kind: Final[SourceKind] = "virtual"

    def __init__(self, room: Room, *, colour_times: int = 2) -> None:
        """`colour_times`: see `Sensor`."""
        self._room = room
        self._sensor = Sensor(room, colour_times=colour_times)
        self.camera = self._sensor.camera
        rng = np.random.default_rng([room.seed, 5])
        self._performer = Performer(rng, away(room, room.dominant), room.dominant)
        self._track = Track(self._live(), rng)
        self._cue: Cue | None = None
        self._index = 0

    def obey(self, cue: Cue) -> None:
        """Do what a cue says, from the next moment on."""
        self._cue = cue

    def skip(self, seconds: float) -> None:
        """Let time pass without a frame."""
        until = self._index + round(seconds * FPS)
        while self._index < until:  # step by step: a cue is heard when the one before is done
            self._track.at(self._index / FPS)
            self._index += 1

    def read(self, timeout_s: float) -> Frame:
        """Return the next frame."""
        del timeout_s  # it never has to wait
        t_s = self._index / FPS
        self._index += 1
        aim = self._track.at(t_s)
        side = self._room.dominant
        hand = posed(self._room.user, pointing(self._room.user, side, aim, curl=1.0))
        rests = self._track.tool_at(t_s) == "wedge"
        things = [wedge(aim.x_mm, aim.y_mm, aim.yaw_deg)] if rests else []
        return self._sensor.frame(round(t_s * 1e6), [hand], things)

    def close(self) -> None:
        """There is nothing to let go."""

    def _live(self) -> Iterator[Segment]:
        while True:
            cue, self._cue = self._cue, None
            if cue is None:
                yield from self._stay()
            elif cue.name == "background":
                yield from self._go(away(self._room, self._room.dominant))
            elif cue.name in STATES:
                yield from self._hold(*STATES[cue.name])
            else:
                yield from self._sweep(cue.pitch_deg)

    def _stay(self) -> Iterator[Segment]:
        """Keep doing the same for a moment: a pressed finger stays pressed."""
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
        """Draw the finger along one row and on to the next."""
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
