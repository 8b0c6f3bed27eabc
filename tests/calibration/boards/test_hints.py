"""A board that cannot be used is refused with its reason, on pictures of the virtual camera."""

import numpy as np
import pytest

from halo_calibration.boards.board import SHEET, Projected
from halo_calibration.errors import CalibrationError
from halo_calibration.solvers.projector import projector_by_markers
from halo_calibration.solvers.surface import surface_by_markers
from halo_service.virtual.props import printed
from tests.placed import Place, room

PAPER = SHEET.picture(297.0, 210.0, 4)
BOARD = Projected(1280, 800)
SHOWN = BOARD.picture()


def covered(picture, rows, columns, grey=200):
    """A picture with a part of it hidden; shares of its height and width."""
    height, width = picture.shape
    hidden = picture.copy()
    hidden[
        int(rows[0] * height) : int(rows[1] * height),
        int(columns[0] * width) : int(columns[1] * width),
    ] = grey
    return hidden


def turned_over(picture):
    return np.ascontiguousarray(picture[:, ::-1])


BLANK = np.full_like(PAPER, 255)


@pytest.mark.parametrize(
    ("paper", "fields", "why"),
    [
        (covered(PAPER, (0, 1), (0, 0.55)), {}, "only 4 of .* 12 marks are seen, .* at the left"),
        (covered(PAPER, (0.4, 1), (0, 1)), {}, "only 4 of .* 12 marks are seen, .* lower edge"),
        (turned_over(PAPER), {}, "surface sheet is seen mirrored: print the file as it is"),
        (PAPER, {"blur_px": 5.0}, "blurred: clean the camera's lens"),
        (PAPER, {"light": 4.0, "exposure_ms": 33.0}, "overexposed .*: dim the lamp"),
        (PAPER, {"light": 0.05, "exposure_ms": 5.0}, "too dark: switch on a light"),
        (BLANK, {}, "surface sheet is not seen: put it flat in the middle"),
    ],
    ids=["left half", "lower half", "mirrored", "blurred", "overexposed", "dark", "blank"],
)
def test_a_printed_sheet_that_cannot_be_used_says_why(paper, fields, why):
    place = Place(room(sheets=(printed(paper, 150.0, 100.0, 297.0),), **fields))
    camera = place.camera
    with pytest.raises(CalibrationError, match=why):
        surface_by_markers(place.colour(), camera.colour, camera.colour_from_depth, place.plane)


@pytest.mark.parametrize(
    ("shown", "fields", "why"),
    [
        (covered(SHOWN, (0, 1), (0, 0.5)), {}, "% of the surface .* hidden at the left"),
        (covered(SHOWN, (0.5, 1), (0, 1), 0), {}, "% of the surface .* hidden at the near"),
        (covered(SHOWN, (0, 1), (0, 0.75)), {}, "only [1-7] of the projected board's 45 marks"),
        (turned_over(SHOWN), {}, "projected board is seen mirrored: switch off rear projection"),
        (SHOWN, {"blur_px": 5.0}, "blurred: focus the projector"),
        (SHOWN, {"light": 1.0, "exposure_ms": 25.0}, "overexposed .*: dim the lamp"),
        (SHOWN, {"light": 0.0, "exposure_ms": 0.5}, "too dark"),
        (np.zeros_like(SHOWN), {}, "projected board is not seen: show it full screen"),
    ],
    ids=["left", "near", "most", "mirrored", "blurred", "overexposed", "dark", "off"],
)
def test_a_projected_board_that_cannot_be_used_says_why(shown, fields, why):
    place = Place(room(**{"light": 0.5, "exposure_ms": 5.0, **fields}))
    camera = place.camera
    with pytest.raises(CalibrationError, match=why):
        projector_by_markers(
            place.colour(shown), BOARD, camera.colour, camera.colour_from_depth, place.plane
        )
