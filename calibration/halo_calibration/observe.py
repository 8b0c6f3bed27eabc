"""What the sensing's own stages make of a finger in one frame, for the solvers to read."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

from halo_service.profile import Profile
from halo_service.sensing.background import Drift, excess_depth, follow_drift
from halo_service.sensing.correction import correct
from halo_service.sensing.detections import Detection, detections
from halo_service.sensing.finger_frame import FingerFrame, unit
from halo_service.sensing.fingertips import locate
from halo_service.sensing.label_pixels import window
from halo_service.sensing.nail import halo_behind_mm
from halo_service.sensing.neighbours import without_others
from halo_service.sensing.readings import readings
from halo_service.sensing.scale import Scale
from halo_service.sensing.segmentation import Segmentation, infrared_silhouette, segment
from halo_service.sensing.settings import SensingSettings
from halo_service.values import Fingertip, Frame, Side, Tracked

DetectHands = Callable[[Frame], Tracked]
"""The hand tracker: finds the hands in one frame."""

THICKNESS_MM = 13.0
"""Chosen: a fingertip from pad to nail, where none was measured."""
REACH_MM = 130.0
"""Half the window around the tip: a hand from its wrist, so that all its fingers are in it."""
LINE_PX = 15
"""How far beyond the tip the finger's line is followed (chosen: the halo's reach)."""


@dataclass(frozen=True, slots=True)
class Observation:
    """One finger in one frame."""

    time_us: int
    side: Side
    x_mm: float
    y_mm: float
    pitch_deg: float
    yaw_deg: float
    top_mm: float
    """Height of the finger's upper side above the surface; nan where unmeasured."""
    raw: float
    """The halo's signal before correction, mm px."""
    corrected: float
    line_px: int
    """Halo pixels on the finger's line (paper 4.3.6)."""
    depths_mm: tuple[float, ...] = (math.nan, math.nan, math.nan)
    """The other readings (see `sensing.readings`), before correction; nan if hidden."""
    width_mm: float = math.nan
    """Of the fingertip; nan where its sides are not clear."""
    halo_behind_mm: float = math.nan
    """How far behind the pad the halo is deepest; nan where it is hidden."""
    seen_deg: float = 45.0
    """Angle between the finger and the line of sight; nan where the pitch was not measured."""

    @property
    def readings(self) -> tuple[float, ...]:
        """All of them, the signal first."""
        return (self.raw, *self.depths_mm)


class Observer:
    """Observes the index finger frame by frame; its only state is the depth drift."""

    def __init__(
        self,
        profile: Profile,
        detect: DetectHands,
        settings: SensingSettings,
        side: Side = Side.UNKNOWN,
    ) -> None:
        """`profile` needs no touch states; `side`: the hand to look for, unknown for any."""
        self._profile = profile
        self._detect = detect
        self._settings = settings
        self._side = side
        self._drift = Drift()

    def see(self, frame: Frame) -> Observation | None:
        """Return the surest hand's index finger, or None."""
        profile = self._profile
        scale = Scale(frame.depth, profile)
        drift_mm = self._drift.offset_mm
        self._drift = follow_drift(self._drift, frame.depth, profile.background, frame.time_us)
        seen = [
            each
            for each in detections(self._detect(frame), scale)
            if self._side in (Side.UNKNOWN, each.side)
        ]
        if not seen:
            return None
        detection = max(seen, key=lambda each: each.confidence)
        segmentation = self._around(detection, frame, scale.on_surface, drift_mm)
        if segmentation.hand.size == 0:
            return None
        segmentation = without_others(segmentation, detection)
        tip = locate(detection, segmentation, frame.depth, profile, THICKNESS_MM)
        raw, *depths_mm = readings(segmentation, tip, profile)
        return Observation(
            frame.time_us,
            detection.side,
            *tip.pad_mm,
            tip.pitch_deg,
            tip.yaw_deg,
            tip.top_mm,
            raw,
            correct(raw, tip, profile.correction),
            _line_pixels(segmentation, tip),
            tuple(depths_mm),
            tip.width_mm,
            halo_behind_mm(segmentation, tip, profile),
            tip.seen_deg,
        )

    def _around(
        self, detection: Detection, frame: Frame, px_per_mm: float, drift_mm: float
    ) -> Segmentation:
        """Segment what is around a finger."""
        background, (depth, infrared) = self._profile.background, (frame.depth, frame.ir)
        tip = FingerFrame(detection.tip_px, (0.0, -1.0), px_per_mm)
        rows, columns = part = window(tip, depth.shape, REACH_MM)
        excess_mm = excess_depth(depth, background, drift_mm, part)
        solid = infrared_silhouette(infrared, background, excess_mm, px_per_mm, part)
        threshold_mm = self._profile.halo_threshold_mm
        return segment(excess_mm, self._settings, threshold_mm, solid, columns.start, rows.start)


def _line_pixels(segmentation: Segmentation, tip: Fingertip) -> int:
    """Count halo pixels on the line from the distal joint through the tip and just beyond it.

    The paper (4.3.6) estimates the height from them, so profiles store them for its method. It
    follows the line between tip and joint; a halo is on the surface, so the same line is followed
    on past the tip, where surface is.
    """
    dx, dy = unit(tip.distal_px, tip.tip_px)
    x, y = segmentation.inside(tip.distal_px)
    height, width = segmentation.halo.shape
    count = 0
    for step in range(round(math.dist(tip.distal_px, tip.tip_px)) + LINE_PX):
        column, row = round(x + dx * step), round(y + dy * step)
        if 0 <= column < width and 0 <= row < height:
            count += bool(segmentation.halo[row, column])
    return count
