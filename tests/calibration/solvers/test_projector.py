"""The projector's pixels are found on the surface, by three ways of looking."""

import numpy as np
import pytest

from halo_calibration.boards.board import Projected, crosses
from halo_calibration.boards.detect import DetectedBoard
from halo_calibration.boards.graycode import Decoded, count, decode, patterns
from halo_calibration.errors import CalibrationError
from halo_calibration.solvers.projector import (
    CROSSES,
    projector_by_gray_code,
    projector_by_touches,
    projector_of,
)
from halo_service.geometry.camera import Lens
from halo_service.geometry.surface import Surface
from halo_service.virtual.projector import Projector
from tests.placed import Place, grid, hung, off_px, room, sent

TABLE = Surface("table", 300.0, 200.0, np.eye(4))
PLAIN = Projector()
BACK = np.linalg.inv(PLAIN.projector_from_surface())


def test_gray_code_gives_the_homography_in_a_dim_room():
    projector = hung(30.0, 640, 480)
    fields = {"material": "plastic", "light": 0.05, "exposure_ms": 8.0}
    place = Place(room(1000.0, 15.0, projector=projector, **fields))
    size = projector.width_px, projector.height_px
    decoded = decode([place.colour(each) for each in patterns(*size)], *size)
    solved = projector_by_gray_code(
        decoded, place.camera.colour, place.camera.colour_from_depth, place.plane
    )
    off = off_px(place, solved)
    print(f"{off.mean():.2f} px, at most {off.max():.2f}; {len(solved.off_px)} points")
    assert off.mean() < 1.5
    assert solved.covered > 0.9


def touched(noise_mm=1.5, seed=1, projector=PLAIN):
    """Three touches of each cross, with noise."""
    places = crosses(projector.width_px, projector.height_px)
    back = np.linalg.inv(projector.projector_from_surface())
    rng = np.random.default_rng(seed)
    return [place + rng.normal(0.0, noise_mm, (3, 2)) for place in sent(back, places)]


def test_touched_crosses_give_the_homography():
    off = []
    for seed in range(20):
        solved = projector_by_touches(touched(2.0, seed), 1280, 800, TABLE)
        back = np.linalg.inv(solved.projector.projector_from_surface)
        truth = sent(PLAIN.projector_from_surface(), grid(300.0, 200.0, 20.0))
        off.append(np.linalg.norm(sent(back, truth) - grid(300.0, 200.0, 20.0), axis=1))
        assert solved.error_mm < 4.0
    print(f"{np.mean(off):.2f} mm, at most {np.max(off):.2f}")
    assert np.mean(off) < 2.0


def test_a_cross_touched_elsewhere_is_named_and_left_out():
    touches = touched(0.3)
    touches[2] = touches[2] + (45.0, 10.0)
    solved = projector_by_touches(touches, 1280, 800, TABLE)
    assert solved.outliers == ("the far right cross",)
    truth = sent(PLAIN.projector_from_surface(), grid(300.0, 200.0))
    off = sent(solved.projector.projector_from_surface, grid(300.0, 200.0)) - truth
    assert np.linalg.norm(off, axis=1).mean() < 3.0


def test_the_nine_crosses_have_names_of_their_own():
    assert len(set(CROSSES)) == 9
    assert (CROSSES[0], CROSSES[4], CROSSES[8]) == ("far left", "middle", "near right")


def straying(index):
    touches = touched(0.3)
    touches[index][0] += (0.0, 20.0)
    return touches


def in_a_line():
    return [np.tile(place * (1.0, 0.02), (3, 1)) for place in sent(BACK, crosses(1280, 800))]


def far_away():
    return [np.add(touch, (900.0, 0.0)) for touch in touched(0.3)]


@pytest.mark.parametrize(
    ("touches", "why"),
    [
        (touched(projector=Projector(mirrored=True)), "is mirrored: switch off rear projection"),
        (straying(4), "of the middle cross lie up to (19|20) mm apart"),
        (in_a_line(), "in a line"),
        (far_away(), "lights only 0 % of the surface"),
        ([np.tile(touch[::-1][:1], (3, 1)) for touch in touched(7.0, 3)], "off by|contradict"),
    ],
    ids=["mirrored", "unsteady", "in a line", "outside the surface", "careless"],
)
def test_touches_that_make_no_homography_are_refused(touches, why):
    with pytest.raises(CalibrationError, match=why):
        projector_by_touches(touches, 1280, 800, TABLE)


LENS = Lens(1280, 720, 610.0, 610.0, 640.0, 360.0)
OVER = TABLE.moved(np.eye(3), 300.0, 200.0)
OVER.camera_from_surface[:3, 3] = (-150.0, -100.0, 500.0)
BOARD = Projected(1280, 800)


def seen_of(places_mm, which, noise_px=0.0):
    px = OVER.in_picture(places_mm, LENS, np.eye(4))
    px = px + np.random.default_rng(1).normal(0.0, noise_px, px.shape)
    missing = tuple(n for n in range(len(BOARD.points_px)) if n not in which)
    return DetectedBoard(BOARD.points_px[which], px[which], tuple(which), missing)


ALL = list(range(len(BOARD.points_px)))
POINTS = sent(BACK, BOARD.points_px)


def test_corners_that_contradict_are_named():
    seen = seen_of(POINTS, ALL)
    seen.picture[[7, 20]] += 30.0
    solved = projector_of(seen, BOARD, LENS, np.eye(4), OVER)
    assert solved.outliers == ("corner 7", "corner 20")
    assert solved.error_px < 0.1
    assert solved.off_px[7] > 20.0
    assert solved.off_mm[7] > 5.0


@pytest.mark.parametrize(
    ("seen", "why"),
    [
        (seen_of(POINTS * (1.0, 0.02) + (0.0, 90.0), ALL), "in a line"),
        (seen_of(POINTS, ALL[:9]), "in a line"),
        (seen_of(POINTS, [n for n in ALL if n % 9 < 4]), "hidden (at the|in the)"),
        (seen_of(POINTS, ALL, noise_px=2.5), "fit is off by .* px, and 3 are the most|contradict"),
        (seen_of((300.0, 0.0) + POINTS * (-1.0, 1.0), ALL), "is mirrored"),
        (
            seen_of(np.random.default_rng(2).uniform(0, 200, (45, 2)), ALL),
            "contradict",
        ),
    ],
    ids=["flat", "one row", "half", "noisy", "mirrored", "anything"],
)
def test_corners_that_make_no_homography_are_refused(seen, why):
    with pytest.raises(CalibrationError, match=why):
        projector_of(seen, BOARD, LENS, np.eye(4), OVER)


def test_mirrored_stripes_are_refused():
    places = grid(300.0, 200.0, 10.0)
    mirrored = Projector(mirrored=True).projector_from_surface()
    px = OVER.in_picture(places, LENS, np.eye(4))
    with pytest.raises(CalibrationError, match="is mirrored"):
        projector_by_gray_code(
            Decoded(1280, 800, px, sent(mirrored, places)), LENS, np.eye(4), OVER
        )


def test_the_stripes_are_as_many_as_they_say():
    for size in [(1280, 800), (1920, 1080), (640, 480)]:
        shown = list(patterns(*size))
        assert len(shown) == count(*size)
        assert {each.shape for each in shown} == {size[::-1]}
    assert count(1280, 800) == 36


def test_stripes_seen_straight_give_their_pixels():
    decoded = decode(list(patterns(1280, 800)), 1280, 800)
    off = decoded.picture + 0.5 - decoded.projector
    assert len(off) == 320 * 200
    assert np.abs(off).max() <= 2.0


def grey(level):
    return np.full((800, 1280), level, np.uint8)


@pytest.mark.parametrize(
    ("pictures", "why"),
    [
        ([grey(255)] * 36, "overexposed"),
        ([grey(90)] * 36, "light is not seen"),
        ([grey(200), grey(20), *[grey(90)] * 34], "stripes cannot be separated"),
    ],
    ids=["blown out", "no light", "too fast"],
)
def test_unreadable_stripes_are_refused(pictures, why):
    with pytest.raises(CalibrationError, match=why):
        decode(pictures, 1280, 800)
