"""Why a board is not seen as it should be, in a sentence with the remedy. Pure.

Rule: refused by outcome, explained by cause. A picture that is blurred or too bright is no fault
while enough of the board is read from it.
"""

from __future__ import annotations

import cv2
import numpy as np

from halo_calibration.boards.board import Board, Picture, Printed
from halo_calibration.boards.detect import DetectedBoard, detect, grey_of
from halo_calibration.errors import CalibrationError
from halo_calibration.image_places import largest, place

LEAST_SHARE = 0.6
"""Of a sheet's markers: with half of them hidden, the other half's far edge is guessed."""
LEAST_CORNERS = 8
"""Of a projected board: twice what its homography needs. How much of the surface they cover is
checked where that is known."""
MIRRORED = 3
"""So many more points in the mirrored picture are no accident."""
WHITE, WHITE_SHARE = 250, 0.02
"""Grey level from which a pixel is blown out, and the share of the picture in one piece from
which that is more than a reflection."""
DARK = 40
"""If the brightest hundredth of a picture is darker, the picture shows nothing."""
WINDOW_PX, CONTRAST, STRONGEST = 31, 70, 0.6
"""A mark's edge is where so many grey levels lie within so many pixels, and so much of the most
that do anywhere: wood's grain is soft even in focus."""
SOFT = 0.2
"""Steepest slope over contrast, per px: an edge in focus has 0.5, one blurred by 2 px 0.2."""


def require_seen(seen: DetectedBoard, picture: Picture, board: Board) -> None:
    """Raise `CalibrationError` where a picture shows too little of a board to go on with."""
    if isinstance(board, Printed):
        enough = len(seen.missing) <= (1.0 - LEAST_SHARE) * len(board.middles_mm)
    else:
        enough = len(seen.numbers) >= LEAST_CORNERS
    if not enough:
        raise CalibrationError(explain(seen, picture, board))


def explain(seen: DetectedBoard, picture: Picture, board: Board) -> str:
    """Say why so little of the board is seen, the likeliest reason first."""
    grey, printed = grey_of(picture), isinstance(board, Printed)
    mirrored = detect(np.ascontiguousarray(grey[:, ::-1]), board)
    if len(mirrored.numbers) >= len(seen.numbers) + MIRRORED:
        remedy = (
            "print the file as it is, without 'mirror', with its face up"
            if printed
            else "switch off rear projection or mirroring in the projector's menu"
        )
        return f"the {board.name} is seen mirrored: {remedy}, and try again"
    blown, where = largest(grey >= WHITE)
    if blown > WHITE_SHARE * grey.size:
        return (
            f"the camera's picture is overexposed {where}: dim the lamp or the projector, keep "
            f"the sun out, or give the camera a shorter exposure, and try again"
        )
    if float(np.percentile(grey, 99)) < DARK:
        return "the camera's picture is too dark: switch on a light, and try again"
    if _soft(grey):
        remedy = "clean the camera's lens" if printed else "focus the projector"
        return f"the camera's picture is blurred: {remedy}, let nothing move, and try again"
    return _hidden(seen, board)


def _hidden(seen: DetectedBoard, board: Board) -> str:
    if not seen.numbers:
        what = (
            "put it flat in the middle of"
            if isinstance(board, Printed)
            else "show it full screen in"
        )
        return (
            f"the {board.name} is not seen: {what} the camera's view, in focus and in even light, "
            f"and try again"
        )
    every = len(seen.missing) + len(set(seen.numbers))
    return (
        f"only {every - len(seen.missing)} of the {board.name}'s {every} marks are seen, and those "
        f"{_hidden_at(seen, board)} are hidden: take away what covers them, or move the camera so "
        f"that it sees them all, and try again"
    )


def _hidden_at(seen: DetectedBoard, board: Board) -> str:
    """Say where on the board the missing marks lie, as one reads it."""
    if isinstance(board, Printed):
        corners = np.concatenate([board.corners(marker) for marker in board.middles_mm])
        missing = np.array([board.middles_mm[marker] for marker in seen.missing])
    else:
        corners, missing = board.points_px, board.points_px[list(seen.missing)]
    low, high = corners.min(axis=0), corners.max(axis=0)
    x, y = (missing.mean(axis=0) - low) / (high - low)
    return place(float(x), float(y), rows=("upper", "", "lower"))


def _soft(grey: Picture) -> bool:
    """Say whether the picture's edges are blurred; without edges there is nothing to say."""
    calm = cv2.GaussianBlur(grey, (0, 0), 0.8).astype(np.float32)
    slope = cv2.magnitude(
        cv2.Sobel(calm, cv2.CV_32F, 1, 0, scale=0.125),
        cv2.Sobel(calm, cv2.CV_32F, 0, 1, scale=0.125),
    )
    window = np.ones((WINDOW_PX, WINDOW_PX), np.uint8)
    contrast = cv2.dilate(calm, window) - cv2.erode(calm, window)
    edges = contrast > max(CONTRAST, STRONGEST * float(contrast.max()))
    if not edges.any():
        return False
    return float(np.median((cv2.dilate(slope, window) / contrast.clip(1.0))[edges])) < SOFT
