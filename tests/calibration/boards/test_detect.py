"""Marks are measured to a tenth of a pixel, and stand the way the world reads them."""

import cv2
import numpy as np
import pytest

from halo_calibration.boards.board import (
    ANCHOR,
    APRILTAG,
    ARUCO,
    SHEET,
    SQUARE,
    Projected,
    anchor,
    crosses,
    marker_squares,
)
from halo_calibration.boards.detect import detect
from halo_service.errors import UserError

FINER = 8
TAG_0 = (
    "########",
    "#..#.#.#",
    "##...#.#",
    "##..####",
    "#.#.####",
    "##.#..##",
    "####.###",
    "########",
)


def drawn(family, marker, size, middle, turn, blur):
    """A 220 x 220 picture of a marker and where its corners are, pixel centres at integers."""
    squares = np.where(marker_squares(family, marker), 0, 255).astype(np.uint8)
    cos, sin = np.cos(turn), np.sin(turn)
    place = np.array([[cos, -sin, middle[0]], [sin, cos, middle[1]], [0.0, 0.0, 1.0]])
    side = size / family.modules
    place = place @ np.array([[side, 0.0, -size / 2.0], [0.0, side, -size / 2.0], [0, 0, 1.0]])
    corner = np.array([[1.0, 0.0, 0.5], [0.0, 1.0, 0.5], [0.0, 0.0, 1.0]])
    sent = np.linalg.inv(corner) @ np.diag([FINER, FINER, 1.0]) @ place @ corner
    large = cv2.warpPerspective(
        squares, sent, (220 * FINER, 220 * FINER), flags=cv2.INTER_NEAREST, borderValue=255
    )
    picture = cv2.resize(large, (220, 220), interpolation=cv2.INTER_AREA)
    picture = cv2.GaussianBlur(picture, (0, 0), blur)
    noise = np.random.default_rng(1).normal(0.0, 2.0, picture.shape)
    grey = np.clip(picture * 0.6 + 30.0 + noise, 0, 255).astype(np.uint8)
    return grey, size * SQUARE @ np.array([[cos, sin], [-sin, cos]]) + middle - 0.5


@pytest.mark.parametrize("blur", [0.5, 1.0])
@pytest.mark.parametrize(
    ("family", "size"), [(ARUCO, 22), (ARUCO, 27), (ARUCO, 60), (APRILTAG, 45), (APRILTAG, 90)]
)
def test_a_markers_corners_are_found_to_a_tenth_of_a_pixel(family, size, blur):
    rng = np.random.default_rng(size)
    off = []
    for _ in range(8):
        middle, turn = rng.uniform(100.0, 110.0, 2), rng.uniform(-3.1, 3.1)
        picture, truth = drawn(family, 50, size, middle, turn, blur)
        seen = detect(picture, anchor(family.name, 50, 80.0))
        off.append(seen.picture - truth)
    off = np.array(off)
    print(f"{family.name} {size} px, blur {blur}: {np.sqrt(np.mean(off**2)):.3f} px")
    assert np.sqrt(np.mean(off**2)) < 0.1
    assert np.abs(off.mean(axis=(0, 1))).max() < 0.05


@pytest.mark.parametrize(
    "size", [(1280, 720), (1280, 800), (1920, 1080), (1024, 768), (1080, 1920)]
)
def test_the_projected_board_is_found_where_it_says_it_is(size):
    board = Projected(*size)
    picture = board.picture()
    assert picture.shape == size[::-1]
    seen = detect(picture, board)
    assert not seen.missing
    # The projector's pixels count from the corner, the picture's from the centre.
    np.testing.assert_allclose(seen.picture + 0.5, seen.board, atol=0.01)


def test_the_board_is_found_without_a_shift_when_it_is_small():
    board = Projected(1280, 800)
    small = cv2.resize(board.picture(), (400, 250), interpolation=cv2.INTER_AREA)
    seen = detect(small, board)
    off = seen.picture + 0.5 - seen.board * (400 / 1280)
    assert len(seen.numbers) == 45
    assert np.abs(off.mean(axis=0)).max() < 0.05
    assert np.abs(off).max() < 0.3


def test_an_apriltag_is_drawn_as_its_makers_publish_it():
    black = marker_squares(APRILTAG, 0)
    assert tuple("".join("#" if each else "." for each in row) for row in black) == TAG_0
    # Its first corner is at the top left of that picture.
    picture = ANCHOR.picture(112.0, 112.0, 2)
    seen = detect(picture, ANCHOR)
    np.testing.assert_allclose(seen.picture[0], [31.5, 31.5], atol=0.1)
    np.testing.assert_allclose(seen.picture[2], [191.5, 191.5], atol=0.1)


def test_a_number_that_is_seen_twice_is_ignored():
    one = anchor("aruco-4x4", 7, 40.0).picture(60.0, 60.0, 3)
    twice = np.concatenate([one, one], axis=1)
    seen = detect(twice, anchor("aruco-4x4", 7, 40.0))
    assert (seen.numbers, seen.missing) == ((), (7,))


def test_the_sheet_fits_both_papers_and_shares_no_number_with_projected_boards():
    corners = np.concatenate([SHEET.corners(marker) for marker in SHEET.middles_mm])
    assert np.abs(corners).max(axis=0).tolist() == [115.5, 84.5]
    projected = max(
        Projected(*size).grid.getIds().max() for size in [(320, 240), (800, 1280), (900, 900)]
    )
    assert projected < min(SHEET.middles_mm)


@pytest.mark.parametrize(
    ("family", "marker", "size", "why"),
    [
        ("qr", 0, 80.0, "known: aruco-4x4, apriltag-36h11"),
        ("apriltag-36h11", 587, 80.0, "0 to 586"),
        ("aruco-4x4", -1, 80.0, "0 to 99"),
        ("aruco-4x4", 1, 5.0, "10 to 1000 mm"),
    ],
)
def test_a_marker_that_cannot_be_is_refused(family, marker, size, why):
    with pytest.raises(UserError, match=why):
        anchor(family, marker, size)


@pytest.mark.parametrize("size", [(0, 0), (100, 800), (1280, 9000), (4000, 1000)])
def test_a_picture_that_no_projector_has_is_refused(size):
    with pytest.raises(UserError, match="240 to 8192 px"):
        Projected(*size)


def test_the_crosses_lie_row_by_row():
    places = crosses(1280, 800)
    assert places[[0, 2, 8]].tolist() == [[256.0, 160.0], [1024.0, 160.0], [1024.0, 640.0]]
