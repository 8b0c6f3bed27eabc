"""A hand that the hand model does not find, from the shape of what stands above the surface.

Rule: pure. A palm or an arm is thick, a finger is thin. So a thin part that sticks out of a thick
one, which itself comes in from outside, is a finger. Which one, and of which hand, is unknown: the
one that reaches farthest in is reported as an index finger, with low confidence.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from halo_service.hand_tracking.picture import MM_PER_PX, SIZE_PX, in_image, to_picture
from halo_service.hand_tracking.regions import Heights, Mask, Region
from halo_service.values import Hand, Side

CONFIDENCE = 0.3
"""Of such a hand."""
LOW_MM = 5.0
"""What is higher is hand: nearly to the end of a touching finger, which reads low."""
THICK_MM = 23.0
"""What holds a disc of this size is no finger (chosen: a broad finger and a bit)."""
THIN_MM = 8.0
"""What holds no disc of this size is the blurred edge of an arm."""
GAP_MM = 6.0
"""So near to the thick part a finger begins: between it and a palm's round corner."""
LEAST_LENGTH_MM = 15.0
"""A shorter thin part is a knuckle or noise (chosen: half of a finger's last segment)."""
REACH_MM = 45.0
"""A finger ends this near to what reaches farthest in; a thumb ends before (chosen)."""
REACH = 0.3
"""Of two fingers, the one that reaches 10 mm farther in may be 3 mm higher (chosen)."""
END_MM = 6.0
"""A finger's height is the mean of so much of its end."""
BEYOND_MM = 4.0
"""The fingertip reads lower than `LOW_MM` over so much of its end."""
JOINTS = (0.0, 0.45, 0.75, 1.0)
"""Of a stretched finger: root, the two joints and the tip, as shares of its length."""
KNUCKLES_MM, FOLDED_MM, WRIST_MM = 20.0, 18.0, 85.0
"""Between neighbouring knuckles, from a knuckle to the tip of its folded finger, and from the
knuckles to the wrist, of an adult's hand (chosen)."""

Points = NDArray[np.float64]
Grey = NDArray[np.uint8]


def hand_from_blob(
    height_mm: Heights, background_mm: Heights, valid: Mask, region: Region
) -> Hand | None:
    """Return the hand in a region by its lowest finger, or None without one.

    `height_mm`: (H, W) above the empty surface, which is at `background_mm`; `valid`: where that is
    known.
    """
    height = _warped(height_mm, region)
    high = _grey(height > LOW_MM)
    blob = _largest(_grey(cv2.morphologyEx(high, cv2.MORPH_OPEN, _disc(THIN_MM))))
    inside = blob > 0
    unknown = (_warped(valid.astype(np.float32), region) < 1.0).astype(np.uint8)
    outside = cv2.dilate(unknown, _disc(4.0 * MM_PER_PX)) > 0
    outside[[0, -1], :] = outside[:, [0, -1]] = True
    if not (inside & outside).any():
        return None
    # What is nearer to the camera looks larger.
    nearer = 1.0 - float(np.median(height[inside])) / float(np.median(background_mm[valid]))
    thick = _grey(cv2.morphologyEx(blob, cv2.MORPH_OPEN, _disc(THICK_MM / nearer)))
    if not thick.any():
        return None
    entry = np.argwhere(inside & outside).mean(axis=0)[::-1]
    away = np.linalg.norm(np.argwhere(inside)[:, ::-1] - entry, axis=1)
    farthest_mm = MM_PER_PX * float(away.max())
    fingers = [
        finger
        for finger in _fingers(blob, thick, height)
        if _length_mm(entry, finger.tip) > farthest_mm - REACH_MM
    ]
    if not fingers:
        return None
    finger = min(fingers, key=lambda f: f.height_mm - REACH * _length_mm(entry, f.tip))
    palm = np.argwhere(thick).mean(axis=0)[::-1]
    return Hand(
        Side.UNKNOWN, in_image(_landmarks(finger.root, finger.tip, palm), region), CONFIDENCE
    )


class _Finger(NamedTuple):
    """A thin part of a blob; places in picture pixels."""

    root: Points
    tip: Points
    height_mm: float
    """Of its end."""


def _fingers(blob: Grey, thick: Grey, height_mm: Heights) -> list[_Finger]:
    """Return the thin parts that begin at a thick one and are as long as a fingertip."""
    thin = blob & (1 - _grey(cv2.dilate(thick, _disc(GAP_MM))))
    near = cv2.dilate(thick, _disc(2.0 * GAP_MM)) > 0
    count, labels = cv2.connectedComponents(thin)
    found = []
    for number in range(1, count):
        rows, columns = np.nonzero(labels == number)
        begins = near[rows, columns]
        if not begins.any():
            continue
        pixels = np.stack((columns, rows), axis=-1).astype(np.float64)
        root = pixels[begins].mean(axis=0)
        away = np.linalg.norm(pixels - root, axis=1)
        # The mean of its last millimetres: a corner of the outline is not the fingertip.
        end = away > away.max() - END_MM / MM_PER_PX
        tip = pixels[end].mean(axis=0)
        if _length_mm(root, tip) >= LEAST_LENGTH_MM:
            found.append(_Finger(root, tip, float(height_mm[rows[end], columns[end]].mean())))
    return found


def _length_mm(root: Points, tip: Points) -> float:
    return MM_PER_PX * float(np.linalg.norm(tip - root))


def _landmarks(root: Points, tip: Points, palm: Points) -> Points:
    """Return (21, 2) a hand with one stretched finger; the others are folded, towards the palm."""
    along = (tip - root) / np.linalg.norm(tip - root)
    across = np.array((-along[1], along[0]))
    across *= np.copysign(1.0, across @ (palm - root))
    tip = tip + along * BEYOND_MM / MM_PER_PX
    marks = np.empty((21, 2))
    marks[5:9] = [root + share * (tip - root) for share in JOINTS]
    step, folded, wrist = (each / MM_PER_PX for each in (KNUCKLES_MM, FOLDED_MM, WRIST_MM))
    for finger in range(2, 5):
        knuckle = root + (finger - 1) * step * across
        marks[1 + 4 * finger : 5 + 4 * finger] = [
            knuckle - share * folded * along for share in JOINTS
        ]
    marks[0] = root - wrist * along + 1.5 * step * across
    marks[1:5] = [marks[0] + share * (root - step * along - marks[0]) for share in JOINTS]
    return marks


def _largest(mask: Grey) -> Grey:
    """Return the largest connected part, 1 inside."""
    _, labels, stats, _ = cv2.connectedComponentsWithStats(mask)
    if len(stats) < 2:
        return np.zeros(mask.shape, np.uint8)
    return _grey(labels == 1 + int(stats[1:, cv2.CC_STAT_AREA].argmax()))


def _warped(image: Heights, region: Region) -> Heights:
    """Return a region's picture of an image; 0 beyond the image."""
    return np.asarray(cv2.warpAffine(image, to_picture(region), (SIZE_PX, SIZE_PX)), np.float32)


def _grey(image: NDArray[Any]) -> Grey:
    return np.asarray(image, np.uint8)


def _disc(diameter_mm: float) -> Grey:
    size = 2 * round(diameter_mm / MM_PER_PX / 2.0) + 1
    return _grey(cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (size, size)))
