"""The part of a frame around all fingers, and the place of each in it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

from halo_service.profile import Profile, TouchStates
from halo_service.sensing.background import excess_depth
from halo_service.sensing.finger_frame import FingerFrame
from halo_service.sensing.fingertips import locate
from halo_service.sensing.label_pixels import (
    Labels,
    Prediction,
    around,
    is_finger,
    is_hidden,
    label_pixels,
    pixels_of,
    strip_end,
)
from halo_service.sensing.neighbours import without_others
from halo_service.sensing.ridge import height_behind
from halo_service.sensing.scale import Scale
from halo_service.sensing.segmentation import Segmentation, infrared_silhouette, segment
from halo_service.sensing.settings import SensingSettings
from halo_service.sensing.tracks import (
    CLAIM_US,
    Track,
    claim,
    detection_at,
    is_better,
    is_there,
    last_top_mm,
    predict,
)
from halo_service.values import Fingertip, Frame

LEAST_TOP_MM, JOINT_MM = 5.0, 20.0
"""2 cm behind its end a finger's upper side is higher than this, or infrared shows it: skin reads
too far, by more than a flat finger is thick. What is lower and does not show is surface."""
RISE_MM_S = 600.0
"""A fingertip rises slower (chosen: people lift at 0.4 m/s)."""


@dataclass(frozen=True, slots=True, eq=False)
class Scene:
    """The segmented part of a frame, with the predictions of all tracks."""

    frame: Frame
    places: tuple[Prediction, ...]
    """From each track's own motion."""
    claims: tuple[Prediction | None, ...]
    """From recent detections, for tracks that a frame has shown."""
    segmentation: Segmentation
    """The part around all of these places."""
    labels: Labels
    profile: Profile
    settings: SensingSettings


@dataclass(frozen=True, slots=True, eq=False)
class Found:
    """One finger in the present frame."""

    tip: Fingertip
    own: Segmentation
    """The pixels that belong to this finger."""
    followed: bool
    """Found at its predicted place rather than at its new detection."""
    hidden: bool
    """Whether another finger is above a part of it."""


def look(
    frame: Frame,
    fingers: Sequence[Track],
    scale: Scale,
    settings: SensingSettings,
    drift_mm: float,
) -> Scene:
    """Segment what is around the fingers. `drift_mm`: see `excess_depth`."""
    profile = scale.profile
    now_us, size = frame.time_us, scale.on_surface
    places = tuple(_scaled(predict(finger, now_us, size), scale) for finger in fingers)
    claimed = (claim(finger, now_us) for finger in fingers)
    claims = tuple(each and _scaled(each, scale) for each in claimed)
    part = around((*places, *(each for each in claims if each)), frame.depth.shape)
    excess_mm = excess_depth(frame.depth, profile.background, drift_mm, part)
    rows, columns = part
    threshold_mm = profile.halo_threshold_mm
    solid = infrared_silhouette(frame.ir, profile.background, excess_mm, size, part)
    segmentation = segment(excess_mm, settings, threshold_mm, solid, columns.start, rows.start)
    return Scene(
        frame, places, claims, segmentation, label_pixels(places, segmentation), profile, settings
    )


def find(finger: Track, number: int, scene: Scene, states: TouchStates) -> Found | None:
    """Return the fingertip in the present frame, None if it does not show."""
    expected, claimed = scene.places[number], scene.claims[number]
    own = _own(finger, number, expected, scene)
    tip = _tip(finger, expected, own, scene, states)
    if claimed is not None and (tip is None or finger.off_place):
        there = _own(finger, number, claimed, scene)
        seen = _tip(finger, claimed, there, scene, states)
        if seen and is_there(claimed, seen) and is_better(finger, seen, tip):
            return _found(seen, claimed, there, followed=False)
    if tip is None:
        farther = replace(expected, place=strip_end(own, expected.place))
        tip = _tip(finger, farther, own, scene, states)
    return None if tip is None else _found(tip, expected, own, followed=True)


def _found(tip: Fingertip, place: Prediction, own: Segmentation, followed: bool) -> Found:
    return Found(tip, own, followed, is_hidden(own, place.place._replace(tip_px=tip.tip_px)))


def _own(finger: Track, number: int, place: Prediction, scene: Scene) -> Segmentation:
    """Return the pixels around a place that belong to no other finger."""
    pixels = pixels_of(scene.segmentation, scene.labels, number, place)
    now_us = scene.frame.time_us
    if now_us - finger.detection.time_us > CLAIM_US:
        return pixels  # the bones are too old to label pixels
    return without_others(pixels, finger.detection, finger.went_px, place.place)


def _scaled(prediction: Prediction, scale: Scale) -> Prediction:
    """Return a prediction with the scale at the depth of its finger's last joint."""
    place = prediction.place
    behind = place.moved(-JOINT_MM).tip_px
    return replace(prediction, place=place._replace(px_per_mm=scale.px_per_mm(behind)))


def _tip(
    finger: Track, place: Prediction, own: Segmentation, scene: Scene, states: TouchStates
) -> Fingertip | None:
    """Return the fingertip about a place, or None where no finger is."""
    if own.hand.size == 0:  # the place is so far outside the image that no pixel is near it
        return None
    tip = locate(
        detection_at(finger, place.place),
        own,
        scene.frame.depth,
        scene.profile,
        states.finger_thickness_mm,
        states.tip_radius_mm,
    )
    there = place.place._replace(tip_px=tip.tip_px)
    if math.isnan(tip.width_mm) and math.isnan(tip.top_mm) and not is_hidden(own, there):
        return None  # a finger moved away from there faster than it was predicted
    unshown_s = (scene.frame.time_us - finger.shown_us) / 1e6
    if tip.top_mm > last_top_mm(finger) + RISE_MM_S * unshown_s:  # false for nan
        return None  # another hand passes over it
    behind_mm = height_behind(own, there, JOINT_MM)
    lies = behind_mm < LEAST_TOP_MM and not _in_infrared(own, there)  # false for nan: unmeasured
    # By its two sides, which show in the deepest dent; else by its breadth above the surface.
    shows = math.isfinite(tip.width_mm) or is_finger(own, there)
    return tip if shows and not lies else None


def _in_infrared(own: Segmentation, place: FingerFrame) -> bool:
    """Return whether infrared alone shows a shape as broad as a finger."""
    return is_finger(replace(own, hand=own.hand & own.solid), place)
