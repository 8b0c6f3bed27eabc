"""The paper's order: each frame goes through all stages, the hand tracker among them.

As one would write it from section 4.3, with our own parts where the paper is silent: the colour
warp, which is faster than the SDK's, the encoding and the sending. The touch is the rival's of
`halo evaluate`, to the letter; the regressor itself runs, not a grid of it.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Protocol

import cv2
import numpy as np
from numpy.typing import NDArray

from halo_service.evaluation.latency.regressor import Regressor
from halo_service.evaluation.latency.stopwatch import Stopwatch
from halo_service.evaluation.methods.paper.method import PAPER
from halo_service.evaluation.methods.paper.signal import Reading
from halo_service.hand_tracking.blend import IR_SHARE, SHRINK, ColourWarp, Picture, toned
from halo_service.profile import Correction, Profile, TouchStates
from halo_service.sensing import SensingSettings
from halo_service.sources import EndOfSource, Source
from halo_service.values import Depth, Frame, TouchFrame, Tracked

READ_S = 0.25
"""Longest wait for a frame, as in our loop."""


class Finder(Protocol):
    """Finds hands in pictures: a `HandTracker`."""

    def find(self, picture: Picture, time_us: int) -> Tracked:
        """(H, W, 3) uint8 RGB in, hands in its pixels out."""


class Sequential:
    """Senses frames in the paper's order, lap by lap."""

    def __init__(
        self,
        profile: Profile,
        states: TouchStates,
        settings: SensingSettings,
        finder: Finder,
        regressor: Regressor,
        watch: Stopwatch,
    ) -> None:
        """`states`: the four of the profile; the correction is 1 at their place."""
        self._finder = finder
        self._regressor = regressor
        self._watch = watch
        held = states.touch
        self._held = regressor.expect(held.x_mm, held.y_mm, held.pitch_deg, held.yaw_deg)
        self._state = replace(PAPER.start(profile, settings), correct=self._corrected)
        known = profile.background.valid
        middle_mm = np.float32(np.median(profile.background.mean_mm[known]))
        background_mm = np.where(known, profile.background.mean_mm, middle_mm)
        self._warp = ColourWarp(profile.camera, background_mm)

    def run(self, source: Source, publish: Callable[[TouchFrame], None]) -> None:
        """Read frames until the source ends; each is published before the next is read."""
        while True:
            try:
                frame = source.read(READ_S)
            except EndOfSource:
                return
            if isinstance(frame, Frame):
                sensed = self.sensed(frame)
                publish(sensed)
                self._watch.end(sensed)

    def sensed(self, frame: Frame) -> TouchFrame:
        """Sense one frame."""
        lap = self._watch.lap
        colour = _decoded(frame.colour)
        lap("decode")
        warped = None if colour is None else self._warped(colour, frame.depth)
        lap("warp")
        picture = _blended(toned(frame.ir), warped)
        lap("blend")
        tracked = self._finder.find(picture, frame.time_us)
        lap("hands")
        sensed, self._state = PAPER.step(self._state, frame, tracked)
        lap("touch")
        return sensed

    def _corrected(self, reading: Reading, correction: Correction | None) -> float:
        """Return the signal at the place where the states were held."""
        del correction  # the grid that ours interpolates
        self._watch.lap("halo")
        place = (*reading.place_mm, reading.pitch_deg, reading.yaw_deg)
        signal = reading.raw * self._held / self._regressor.expect(*place)
        self._watch.lap("correct")
        return signal

    def _warped(self, colour: Picture, depth: Depth) -> Picture | None:
        places = self._warp.places(depth)
        if places is None:
            return None
        x, y = places * SHRINK + (SHRINK - 1) / 2  # from the half-size picture's pixels to these
        warped = cv2.remap(colour, x, y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
        return np.asarray(warped, dtype=np.uint8)


def _decoded(colour: NDArray[np.uint8] | bytes | None) -> Picture | None:
    if not isinstance(colour, bytes):
        return colour
    picture = cv2.imdecode(np.frombuffer(colour, np.uint8), cv2.IMREAD_COLOR)
    return None if picture is None else np.asarray(picture, dtype=np.uint8)


def _blended(grey: Picture, warped: Picture | None) -> Picture:
    infrared = cv2.cvtColor(grey, cv2.COLOR_GRAY2RGB)
    if warped is None:
        return np.asarray(infrared, dtype=np.uint8)
    rgb = cv2.cvtColor(warped, cv2.COLOR_BGR2RGB)
    return np.asarray(cv2.addWeighted(infrared, IR_SHARE, rgb, 1 - IR_SHARE, 0), dtype=np.uint8)
