"""The printable sheets measure true, and are read back by the detector that they are for."""

import subprocess

import cv2
import numpy as np
import pytest

from halo_calibration.boards.board import ANCHOR, SHEET
from halo_calibration.boards.detect import detect
from halo_calibration.boards.pdf import Page, document
from halo_calibration.boards.sheets import (
    CORNERS_MM,
    CROSS_MM,
    CROSSES_MM,
    PAPERS_MM,
    RULER_MM,
    RULER_X_MM,
    sheets,
)
from halo_service.app.cli import main
from halo_service.virtual.scenarios.study import targets

DPI = 300
MM_PER_PX = 25.4 / DPI
BOARDS = {"surface-sheet": SHEET, "anchor": ANCHOR}
BOARD_FILES = [(name, paper) for name in BOARDS for paper in PAPERS_MM]
FILES = [*BOARD_FILES, *(("first-light", paper) for paper in PAPERS_MM)]


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("targets") / "new"
    assert main(["targets", str(folder)]) == 0
    return folder


@pytest.fixture(scope="module")
def printed(folder, external_program):
    """Every file as pdftoppm prints it."""
    program = external_program("pdftoppm")
    pictures = {}
    for name, paper in FILES:
        out = folder / f"{name}-{paper}"
        command = [program, "-r", str(DPI), "-gray", "-singlefile", "-png", f"{out}.pdf", str(out)]
        subprocess.run(command, check=True, capture_output=True, timeout=60)
        pictures[name, paper] = cv2.imread(f"{out}.png", cv2.IMREAD_GRAYSCALE)
    return pictures


@pytest.mark.parametrize(("name", "paper"), FILES)
def test_a_sheet_is_as_large_as_its_paper(printed, name, paper):
    height_mm, width_mm = np.array(printed[name, paper].shape) * MM_PER_PX
    assert (width_mm, height_mm) == pytest.approx(PAPERS_MM[paper], abs=0.2)


@pytest.mark.parametrize(("name", "paper"), BOARD_FILES)
def test_a_printed_board_measures_true(printed, name, paper):
    picture = printed[name, paper]
    width_mm, height_mm = PAPERS_MM[paper]
    seen = detect(picture, BOARDS[name])
    assert not seen.missing
    measured = (seen.picture + 0.5) * MM_PER_PX
    off = measured - np.add(seen.board, (width_mm / 2.0, height_mm / 2.0))
    print(f"{name} on {paper}: off by {np.abs(off).max():.3f} mm")
    assert np.abs(off).max() < 0.2


@pytest.mark.parametrize("paper", PAPERS_MM)
def test_first_lights_crosses_and_corners_are_printed_where_they_are_looked_for(printed, paper):
    ink = 255.0 - printed["first-light", paper]
    middle = np.array(PAPERS_MM[paper]) / 2.0
    reach = CROSS_MM - 0.5
    for x, y in middle + CROSSES_MM:
        assert _line(ink, (x - 1.0, x + 1.0), (y + 0.5, y + reach)) == pytest.approx(x, abs=0.1)
        assert _line(ink.T, (y - 1.0, y + 1.0), (x - reach, x - 0.5)) == pytest.approx(y, abs=0.1)
    for side, end in ((-1, -1), (1, -1), (1, 1), (-1, 1)):
        x, y = middle + np.array(CORNERS_MM) * (side, end)
        inwards_x, inwards_y = (
            sorted((at, at - sign * reach)) for at, sign in ((x, side), (y, end))
        )
        assert _line(ink, (x - 1.0, x + 1.0), inwards_y) == pytest.approx(x, abs=0.1)
        assert _line(ink.T, (y - 1.0, y + 1.0), inwards_x) == pytest.approx(y, abs=0.1)


def _line(ink, across_mm, along_mm):
    """Where a line that goes down the picture is across, mm."""
    left, right, top, bottom = (round(mm / MM_PER_PX) for mm in (*across_mm, *along_mm))
    dark = ink[top + 2 : bottom - 2, left : right + 1].sum(axis=0)
    return float((np.arange(left, right + 1) + 0.5) @ dark / dark.sum()) * MM_PER_PX


def test_first_lights_crosses_are_the_studys_targets():
    assert np.allclose(np.array(targets()) - np.mean(targets(), axis=0), CROSSES_MM)


@pytest.mark.parametrize(("name", "paper"), FILES)
def test_the_ruler_measures_what_it_says(printed, name, paper):
    picture = printed[name, paper]
    # Only the ends' ticks reach as far to the left as that.
    column = picture[:, round((RULER_X_MM - 3.0) / MM_PER_PX)]
    middle = picture.shape[0] // 2
    reach = round((RULER_MM / 2.0 + 1.5) / MM_PER_PX)
    dark = middle - reach + np.flatnonzero(column[middle - reach : middle + reach] < 128)
    ends = np.split(dark, np.flatnonzero(np.diff(dark) > 1) + 1)
    assert len(ends) == 2
    assert (ends[1].mean() - ends[0].mean()) * MM_PER_PX == pytest.approx(RULER_MM, abs=0.2)


@pytest.mark.parametrize(("name", "paper"), FILES)
def test_nothing_is_printed_where_printers_do_not_reach(printed, name, paper):
    picture = printed[name, paper]
    edge = round(5.0 / MM_PER_PX)
    inner = picture[edge:-edge, edge:-edge]
    assert np.count_nonzero(picture < 255) == np.count_nonzero(inner < 255)


@pytest.mark.parametrize(("name", "paper"), BOARD_FILES)
def test_nothing_is_printed_near_a_marker(printed, name, paper):
    picture, board = printed[name, paper], BOARDS[name]
    # A marker is found by the white around it, as wide as one of its squares.
    square_mm = board.size_mm / board.family.modules
    for marker in board.middles_mm:
        low = board.corners(marker)[0] + np.array(PAPERS_MM[paper]) / 2.0
        (left, top) = np.round((low - square_mm) / MM_PER_PX).astype(int) + 1
        size = round((board.size_mm + 2.0 * square_mm) / MM_PER_PX) - 2
        around = picture[top : top + size, left : left + size].copy()
        inset = round(square_mm / MM_PER_PX) - 3
        around[inset:-inset, inset:-inset] = 255
        assert around.min() == 255


def test_the_same_sheets_are_the_same_bytes():
    assert sheets() == sheets()
    assert set(sheets()) == {f"{name}-{paper}.pdf" for name, paper in FILES}


def test_a_document_of_several_pages_says_where_each_object_is():
    pages = [Page(100.0, 50.0), Page(50.0, 100.0)]
    pages[0].text(1.0, 2.0, "brackets ( and \\ too")
    data = document("two", pages)
    start = int(data.rsplit(b"startxref\n", 1)[1].split()[0])
    assert data[start:].startswith(b"xref\n0 9\n")
    for number, line in enumerate(data[start:].splitlines()[3:11], start=1):
        place = int(line[:10])
        assert data[place:].startswith(b"%d 0 obj" % number)
    assert rb"(brackets \( and \\ too)" in data
    assert b"/Count 2" in data


def test_a_folder_that_cannot_be_created_is_reported(tmp_path, capsys):
    (tmp_path / "file").write_text("")
    assert main(["targets", str(tmp_path / "file" / "under")]) == 2
    assert "choose another folder" in capsys.readouterr().err
