"""Tracks hands in the regions that depth proposes: each hand by a hand model of its own.

A hand that was found is looked at where it was; new ones are sought where something above the
surface belongs to no known hand. With an empty table the model does not run at all.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np

from halo_service.hand_tracking.blob_hand import hand_from_blob
from halo_service.hand_tracking.hands import HandTracker
from halo_service.hand_tracking.picture import in_image, region_picture
from halo_service.hand_tracking.regions import (
    PALM,
    Heights,
    Mask,
    Region,
    find_regions,
    region_of_hand,
)
from halo_service.values import Frame, Hand, Tracked

SAME_PALM_MM = 30.0
"""Two palms nearer to each other than this are one hand, found twice."""
RETRY_US = 300_000
"""A region without a hand (a mug, an elbow) is looked at again after so long,"""
RETRY_MM = 20.0
"""or when its blob has moved this far."""
UNFOUND_US = 300_000
"""What comes in and has no hand for so long is looked at for the shape of a finger: the model needs
some frames for a hand that is just coming in."""


@dataclass(slots=True)
class _Slot:
    """One hand model, which follows one hand from picture to picture."""

    model: Future[HandTracker]
    """Loaded in a thread of its own: the first hand does not wait for the second one's model."""
    hand: Hand | None = None


@dataclass(frozen=True, slots=True)
class _Empty:
    """A region without a hand, by the model or by its shape."""

    region: Region
    time_us: int


class RegionTracker:
    """Hands over a surface of which the empty depth is known. Used from one thread at a time."""

    def __init__(
        self, model_path: Path, background_mm: Heights, valid: Mask, focal_px: float, max_hands: int
    ) -> None:
        """`background_mm`, `valid`: (H, W) of the empty surface; `focal_px`: of the depth camera.

        Raises UserError for a file that is no Hand Landmarker.
        """
        self._background_mm, self._valid = background_mm, valid
        self._px_per_mm = focal_px / max(float(np.median(background_mm[valid])), 1.0)
        loader = ThreadPoolExecutor(1, "hand model")
        models = [loader.submit(HandTracker, model_path, max_hands=1) for _ in range(max_hands)]
        loader.shutdown(wait=False)
        self._slots = [_Slot(model) for model in models]
        models[0].result()  # raises if the file is no model
        self._empty: tuple[_Empty, ...] = ()
        self._shapeless: tuple[_Empty, ...] = ()
        self._unfound_us: int | None = None

    def detect(self, frame: Frame) -> Tracked:
        """Find the hands in one frame, in its own pixels."""
        height_mm = self._background_mm - frame.depth
        height_mm *= (frame.depth > 0) & self._valid
        for slot in self._slots:
            if slot.hand is not None:
                region = region_of_hand(slot.hand, self._px_per_mm)
                slot.hand = self._find(slot, region, height_mm, frame)
        free = next((slot for slot in self._slots if slot.hand is None), None)
        by_shape = None if free is None else self._search(free, height_mm, frame)
        return Tracked(frame.time_us, (*self._hands(), *([by_shape] if by_shape else [])))

    def close(self) -> None:
        """Let the models go."""
        for slot in self._slots:
            slot.model.result().close()

    def _hands(self) -> list[Hand]:
        return [slot.hand for slot in self._slots if slot.hand is not None]

    def _search(self, slot: _Slot, height_mm: Heights, frame: Frame) -> Hand | None:
        """Look for one more hand, in the largest region that was not looked at lately.

        Return the one that the model does not find but its shape shows.
        """
        hands = self._hands()
        proposed = find_regions(height_mm, self._valid, hands, self._px_per_mm)
        self._empty = recent = _recent(self._empty, frame.time_us)
        region = next((each for each in proposed if not self._is_empty(each, recent)), None)
        if region is not None:
            slot.hand = self._find(slot, region, height_mm, frame, hands)
            if slot.hand is None:
                self._empty = (*recent, _Empty(region, frame.time_us))
        if slot.hand is not None:
            self._unfound_us = None
            return None
        return self._by_shape(proposed, height_mm, frame)

    def _by_shape(
        self, proposed: Sequence[Region], height_mm: Heights, frame: Frame
    ) -> Hand | None:
        """Return a hand by its shape, where the model has found none for a while."""
        if not proposed:
            self._unfound_us = None
            return None
        since_us = frame.time_us if self._unfound_us is None else self._unfound_us
        self._unfound_us = since_us
        if 0 <= frame.time_us - since_us < UNFOUND_US:
            return None
        self._shapeless = _recent(self._shapeless, frame.time_us)
        for region in proposed:
            if self._is_empty(region, self._shapeless):
                continue
            hand = hand_from_blob(height_mm, self._background_mm, self._valid, region)
            if hand is not None:
                return hand
            self._shapeless = (*self._shapeless, _Empty(region, frame.time_us))
        return None

    def _find(
        self,
        slot: _Slot,
        region: Region,
        height_mm: Heights,
        frame: Frame,
        hidden: Sequence[Hand] = (),
    ) -> Hand | None:
        """Return the hand in a region, None for none and for one that another slot has."""
        picture = region_picture(height_mm, frame.ir, region, hidden)
        if picture is None:
            return None
        rgb = np.asarray(cv2.cvtColor(picture, cv2.COLOR_GRAY2RGB), np.uint8)
        found = slot.model.result().find(rgb, frame.time_us).hands
        if not found:
            return None
        hand = Hand(found[0].side, in_image(found[0].landmarks_px, region), found[0].confidence)
        others = [each.hand for each in self._slots if each is not slot and each.hand is not None]
        return None if self._is_one_of(hand, others) else hand

    def _is_one_of(self, hand: Hand, others: Sequence[Hand]) -> bool:
        least_px = SAME_PALM_MM * self._px_per_mm
        return any(math.dist(_palm(hand), _palm(other)) < least_px for other in others)

    def _is_empty(self, region: Region, recent: Sequence[_Empty]) -> bool:
        near_px = RETRY_MM * self._px_per_mm
        return any(
            math.dist((region.x_px, region.y_px), (each.region.x_px, each.region.y_px)) < near_px
            for each in recent
        )


def _palm(hand: Hand) -> list[float]:
    return [float(each) for each in hand.landmarks_px[list(PALM)].mean(axis=0)]


def _recent(empty: tuple[_Empty, ...], time_us: int) -> tuple[_Empty, ...]:
    return tuple(each for each in empty if 0 <= time_us - each.time_us < RETRY_US)
