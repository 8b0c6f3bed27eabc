"""The paper's order: each frame goes through all stages, the hand tracker among them.

As one would write it from section 4.3, with what this house has where the paper is silent: the
colour warp is ours, which is faster than the SDK's, and so are encoding and sending.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

import cv2
import numpy as np
from numpy.typing import NDArray

from halo_service.evaluation.latency import paper
from halo_service.evaluation.latency.regressor import Regressor
from halo_service.evaluation.latency.stopwatch import Stopwatch
from halo_service.profile import Profile, TouchStates
from halo_service.sources import EndOfSource, Source
from halo_service.tracking.blend import IR_SHARE, SHRINK, ColourWarp, Picture, toned
from halo_service.values import Depth, Frame, TouchFrame, Tracked

READ_S = 0.25


class Finder(Protocol):
    """Finds hands in pictures: a `HandTracker`."""

    def find(self, picture: Picture, time_us: int) -> Tracked:
        """(H, W, 3) uint8 RGB in, hands in its pixels out."""


class Sequential:
    """Runs one take in the paper's order."""

    def __init__(
        self, profile: Profile, states: TouchStates, finder: Finder, regressor: Regressor
    ) -> None:
        """`states`: the four that hold for its fingers."""
        self._profile = profile
        self._finder = finder
        self._regressor = regressor
        held = states.touch
        self._held = regressor.expect(held.x_mm, held.y_mm, held.pitch_deg, held.yaw_deg)
        self._touches = paper.Touches(profile, states)
        known = profile.background.valid
        middle = np.float32(np.median(profile.background.mean_mm[known]))
        background_mm = np.where(known, profile.background.mean_mm, middle)
        self._warp = ColourWarp(profile.camera, background_mm)

    def run(self, source: Source, publish: Callable[[TouchFrame], None], watch: Stopwatch) -> None:
        """Take frames until the source ends; each is published before the next is taken."""
        while True:
            try:
                frame = source.read(READ_S)
            except EndOfSource:
                return
            if isinstance(frame, Frame):
                told = self.sensed(frame, watch)
                publish(told)
                watch.end(told)

    def sensed(self, frame: Frame, watch: Stopwatch) -> TouchFrame:
        """Sense one frame, lap by lap."""
        colour = _decoded(frame.colour)
        watch.lap("decode")
        warped = None if colour is None else self._warped(colour, frame.depth)
        watch.lap("warp")
        picture = _blended(toned(frame.ir), warped)
        watch.lap("blend")
        hands = self._finder.find(picture, frame.time_us).hands
        watch.lap("hands")
        seen = (paper.fingertip(hand, frame.depth, self._profile) for hand in hands)
        tips = [tip for tip in seen if tip is not None]
        watch.lap("fingertip")
        halo_mm = paper.excess(frame.depth, self._profile.background)
        raw = [paper.signal(halo_mm, tip) for tip in tips]
        watch.lap("halo")
        values = [self._corrected(each, tip) for each, tip in zip(raw, tips, strict=True)]
        watch.lap("correct")
        told = self._touches.frame(frame.time_us, list(zip(tips, values, strict=True)))
        watch.lap("touch")
        return told

    def _corrected(self, raw: float, tip: paper.Tip) -> float:
        """Give a signal as it would read where the states were held."""
        there = self._regressor.expect(tip.x_mm, tip.y_mm, tip.pitch_deg, tip.yaw_deg)
        return raw * self._held / there

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
