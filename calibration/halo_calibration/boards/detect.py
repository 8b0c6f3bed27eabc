"""Finding a board in a picture, to a tenth of a pixel. Pure.

Rule: pixels of pictures have (0, 0) at the centre of the top left one, as the lenses. OpenCV says
which marker is where; the places are measured here, for those of OpenCV 4 are off: a ChArUco
corner by half a pixel (opencv/opencv#28380), a marker's by a quarter, towards its middle.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

from halo_calibration.boards.board import Board, Family, Picture, Printed, Projected
from halo_service.geometry.camera import Points

PROFILES = 16
"""Cuts across each side of a marker."""
MARGIN = 0.15
"""Of a side at each end that is left out: there the other side rounds the corner."""
REACH = 0.55
"""How far a cut reaches to both sides, of one black or white square of the marker: the next edge
is a whole square away, and what is found so is at most half of one off."""
REACH_PX = (1.5, 4.0)
"""Its bounds: an edge's own blur, and more than any edge in focus needs."""
SAMPLES = 25
"""Along a cut."""
ROUNDS = 2
"""The first starts up to a pixel off."""
STRAY_PX = 2.0
"""Corners that end farther from where they were found are of a marker that is partly covered."""
LEAST_CONTRAST = 12.0
"""Grey levels between black and white: six times the camera's noise."""
SADDLE = 0.09
"""Half of the window around a ChArUco corner, of a square: the markers begin at 0.15."""


@dataclass(frozen=True, slots=True, eq=False)
class DetectedBoard:
    """The points of a board that a picture shows."""

    board: Points
    """(N, 2) where they are on it: mm of a printed board, px of a projected one."""
    picture: Points
    """(N, 2) where they are in the picture, px."""
    numbers: tuple[int, ...]
    """Of each point: the marker's number on a printed board, the corner's on a projected one."""
    missing: tuple[int, ...]
    """Numbers on the board that were not seen."""


def detect(picture: Picture, board: Board) -> DetectedBoard:
    """Find a board in an (h, w) or (h, w, 3) uint8 picture; what is not there is `missing`."""
    grey = grey_of(picture)
    return _printed(grey, board) if isinstance(board, Printed) else _projected(grey, board)


def grey_of(picture: Picture) -> Picture:
    """(h, w) of an (h, w) or BGR picture."""
    if picture.ndim == 2:
        return picture
    return np.asarray(cv2.cvtColor(picture, cv2.COLOR_BGR2GRAY), dtype=np.uint8)


def _printed(grey: Picture, board: Printed) -> DetectedBoard:
    family = board.family
    detector = cv2.aruco.ArucoDetector(cv2.aruco.getPredefinedDictionary(family.dictionary))
    quads, ids, _ = detector.detectMarkers(grey)
    found: dict[int, Points] = {}
    for quad, marker in zip(quads, [] if ids is None else ids.ravel().tolist(), strict=True):
        # A number that is seen twice is on two things: neither can be trusted.
        found[marker] = np.empty((0, 2)) if marker in found else _refined(grey, quad[0], family)
    known = [marker for marker in board.middles_mm if len(found.get(marker, ())) == 4]
    nothing = [np.empty((0, 2))]
    return DetectedBoard(
        np.concatenate([board.corners(marker) for marker in known] or nothing),
        np.concatenate([found[marker] for marker in known] or nothing),
        tuple(marker for marker in known for _ in range(4)),
        tuple(marker for marker in board.middles_mm if marker not in known),
    )


def _projected(grey: Picture, board: Projected) -> DetectedBoard:
    detector = cv2.aruco.CharucoDetector(board.grid)
    corners, ids, _, _ = detector.detectBoard(grey)
    numbers = [] if ids is None else ids.ravel().tolist()
    missing = tuple(n for n in range(len(board.points_px)) if n not in numbers)
    if not numbers:
        return DetectedBoard(np.empty((0, 2)), np.empty((0, 2)), (), missing)
    rough = np.asarray(corners, dtype=np.float32).reshape(-1, 1, 2) - np.float32(0.5)
    half = max(2, round(SADDLE * _spacing(rough.reshape(-1, 2), board.points_px[numbers], board)))
    until = (cv2.TERM_CRITERIA_COUNT | cv2.TERM_CRITERIA_EPS, 50, 0.001)
    fine = cv2.cornerSubPix(grey, rough, (half, half), (-1, -1), until)
    places = np.asarray(fine, dtype=np.float64).reshape(-1, 2)
    return DetectedBoard(board.points_px[numbers], places, tuple(numbers), missing)


def _spacing(seen: Points, on_board: Points, board: Projected) -> float:
    """Size of a square in the picture, px."""
    if len(seen) < 2:
        return 0.0
    apart, there = np.ptp(seen, axis=0), np.ptp(on_board, axis=0)
    return float(board.square_px * np.linalg.norm(apart) / np.linalg.norm(there))


def _refined(grey: Picture, quad: Points, family: Family) -> Points:
    """(4, 2) corners of a marker where its sides' lines meet; (0, 2) where they are not clear."""
    corners = np.roll(quad, 2, axis=0) if family.turned else quad
    corners = corners.astype(np.float64)
    for _ in range(ROUNDS):
        lines = [_edge(grey, corners[k], corners[(k + 1) % 4], family.modules) for k in range(4)]
        clear = [line for line in lines if line is not None]
        if len(clear) < 4:
            return np.empty((0, 2))
        meet = [np.cross(clear[k - 1], clear[k]) for k in range(4)]
        corners = np.array([point[:2] / point[2] for point in meet])
    strayed = np.abs(corners - np.roll(quad, 2 if family.turned else 0, axis=0)).max()
    return corners if strayed < STRAY_PX else np.empty((0, 2))


def _edge(grey: Picture, a: Points, b: Points, modules: int) -> Points | None:
    """(3,) the line of a side from a to b, black on its right; None where nothing is black."""
    along = b - a
    length = float(np.linalg.norm(along))
    outward = np.array([along[1], -along[0]]) / length
    reach = float(np.clip(REACH * length / modules, *REACH_PX))
    shares = np.linspace(MARGIN, 1.0 - MARGIN, PROFILES)
    offsets = np.linspace(-reach, reach, SAMPLES)
    places = a + shares[:, None, None] * along + offsets[None, :, None] * outward
    at = places.astype(np.float32)
    cuts = cv2.remap(grey.astype(np.float32), at[..., 0], at[..., 1], cv2.INTER_LINEAR)
    black, white = np.median(cuts[:, :3]), np.median(cuts[:, -3:])
    if white - black < LEAST_CONTRAST:
        return None
    # How much of a cut is black says where it ends, whatever the blur.
    inside = np.clip((white - cuts) / (white - black), -0.5, 1.5).mean(axis=1)
    edge = a + shares[:, None] * along + (reach * (2.0 * inside - 1.0))[:, None] * outward
    vx, vy, x, y = cv2.fitLine(edge.astype(np.float32), cv2.DIST_HUBER, 0, 1e-4, 1e-4).ravel()
    return np.array([vy, -vx, vx * y - vy * x], dtype=np.float64)
