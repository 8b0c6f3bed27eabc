"""Where in the image to look for hands: at what stands above the empty surface.

Rule: pure. Depth separates a hand from the table without knowing what a hand is. So it proposes
square regions, and the hand model looks only there: also at hands that are cut by the image's edge,
at hands as bright as the table, at gloves and sleeves, and at a fraction of the pixels.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from halo_service.values import Hand

Mask = NDArray[np.bool_]
Heights = NDArray[np.float32]
"""(H, W) mm above the empty surface; 0 where nothing was measured."""

REGION_MM = 420.0
"""Side of a region. A hand fills a third of it, as the palm detector expects (of 45 virtual frames
of a hand that the image's edge cuts, it found all; in regions of half the size, a third)."""
HAND_MM = 10.0
"""What is higher than this is a hand, an arm or an object, and not noise."""
LEAST_AREA_MM2 = 900.0
"""A smaller blob is noise: a finger has as much."""
HAND_LENGTH_MM = 190.0
"""The part of a blob this near to its far end is the hand; the rest is the arm."""
ARM_MM = 70.0
"""Half the width of the strip behind a wrist that is its arm: a wide sleeve."""
AROUND_HAND_MM = 25.0
"""Flesh reaches this far beyond the landmarks' hull."""
REDUCE = 4
"""Blobs are sought in every fourth pixel, each way."""

PALM = (0, 5, 9, 13, 17)
WRIST, KNUCKLES = 0, (5, 9, 13, 17)
"""MediaPipe's landmarks."""


@dataclass(frozen=True, slots=True)
class Region:
    """A square of the image that holds one hand; it may reach beyond the image."""

    x_px: float
    y_px: float
    """Its centre."""
    side_px: float


def region_of_hand(hand: Hand, px_per_mm: float) -> Region:
    """Return the region around a hand that was found."""
    low, high = hand.landmarks_px.min(axis=0), hand.landmarks_px.max(axis=0)
    x, y = ((low + high) / 2.0).tolist()
    return Region(x, y, REGION_MM * px_per_mm)


def find_regions(
    height_mm: Heights, measured: Mask, hands: Sequence[Hand], px_per_mm: float
) -> tuple[Region, ...]:
    """Return the regions that may hold a hand other than `hands`, the largest blob first.

    `measured`: (H, W) True where the background is known; `px_per_mm`: at the surface.
    """
    size = (height_mm.shape[1] // REDUCE, height_mm.shape[0] // REDUCE)
    high = (height_mm > HAND_MM).astype(np.uint8)
    blobs = cv2.resize(high * 255, size, interpolation=cv2.INTER_AREA) > 127
    blobs = without_hands(hands, blobs, px_per_mm / REDUCE)
    count, labels, stats, _ = cv2.connectedComponentsWithStats(blobs.astype(np.uint8))
    areas = stats[:, cv2.CC_STAT_AREA]
    least_px = LEAST_AREA_MM2 * (px_per_mm / REDUCE) ** 2
    large = sorted((n for n in range(1, count) if areas[n] >= least_px), key=lambda n: -areas[n])
    if not large:
        return ()
    rim = _rim(cv2.resize(measured.astype(np.uint8), size, interpolation=cv2.INTER_NEAREST) > 0)
    return tuple(_region(labels == n, rim, px_per_mm) for n in large)


def without_hands(hands: Sequence[Hand], blobs: Mask, scale: float) -> Mask:
    """Return the blobs less the hands and their arms; a hand takes from its own blobs alone.

    `blobs`: reduced pixels; `scale`: of them per mm.
    """
    _, labels = cv2.connectedComponents(blobs.astype(np.uint8))
    free = blobs.copy()
    for hand in hands:
        flesh, arm = _covered(hand, blobs.shape, scale)
        own = np.isin(labels, np.unique(labels[flesh & blobs]))
        free &= ~(flesh | (arm & own))
    return free


def _rim(measured: Mask) -> Mask:
    """Return the outermost pixels of what is measured: hands come in there."""
    border = cv2.BORDER_CONSTANT
    kernel = np.ones((5, 5), np.uint8)
    inner = cv2.erode(measured.astype(np.uint8), kernel, borderType=border, borderValue=(0,))
    return np.asarray(measured & (inner == 0))


def _region(blob: Mask, rim: Mask, px_per_mm: float) -> Region:
    """Return the region around the far end of a blob, seen from where it enters the image."""
    rows, columns = np.nonzero(blob)
    entry = rim[rows, columns]
    if entry.any():
        away = np.hypot(columns - columns[entry].mean(), rows - rows[entry].mean())
        far = int(away.argmax())
        length_px = HAND_LENGTH_MM * px_per_mm / REDUCE
        hand = np.hypot(columns - columns[far], rows - rows[far]) < length_px
        rows, columns = rows[hand], columns[hand]
    # The middle of the extent, not of the mass: an outstretched finger is part of the hand.
    x, y = (float(each.min() + each.max()) / 2.0 for each in (columns, rows))
    return Region(_full(x), _full(y), REGION_MM * px_per_mm)


def _covered(hand: Hand, shape: tuple[int, ...], scale: float) -> tuple[Mask, Mask]:
    """Return the reduced pixels of a hand and of its arm; `scale`: reduced px per mm."""
    points = ((hand.landmarks_px + 0.5) / REDUCE - 0.5).astype(np.float32)
    hull = np.zeros(shape, np.uint8)
    cv2.fillConvexPoly(hull, np.rint(cv2.convexHull(points)).astype(np.int32), (1,))
    reach = 2 * round(AROUND_HAND_MM * scale) + 1
    flesh = cv2.dilate(hull, cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (reach, reach))) > 0
    wrist = points[WRIST]
    back = wrist - points[list(KNUCKLES)].mean(axis=0)
    ux, uy = back / max(math.hypot(float(back[0]), float(back[1])), 1.0)
    dx = np.arange(shape[1], dtype=np.float32)[None, :] - wrist[0]
    dy = np.arange(shape[0], dtype=np.float32)[:, None] - wrist[1]
    arm = (dx * ux + dy * uy > 0.0) & (np.abs(dy * ux - dx * uy) < ARM_MM * scale)
    return np.asarray(flesh), np.asarray(arm)


def _full(reduced_px: float) -> float:
    """Return a place of the reduced image in the full one; both count pixel centres."""
    return REDUCE * (reduced_px + 0.5) - 0.5
