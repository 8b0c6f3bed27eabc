"""The printable sheets, true to scale on A4 and Letter: the surface's, the anchor's, first light's.

Rule: what a sheet shows lies around the page's middle, with a ruler to check the print and a
sentence how to print it. So two sheets with their edges aligned have one middle.
"""

from __future__ import annotations

import numpy as np

from halo_calibration.boards.board import ANCHOR, SHEET, Printed, marker_squares
from halo_calibration.boards.pdf import Page, document

PAPERS_MM = {"a4": (297.0, 210.0), "letter": (279.4, 215.9)}
"""Landscape."""
RULER_MM = 100
RULER_X_MM = 14.0
"""From the left edge: printers leave out up to 6 mm, and markers want a square of white."""
CROSSES_MM = tuple((x, y) for y in (-75.0, -25.0, 25.0, 75.0) for x in (-75.0, -25.0, 25.0, 75.0))
"""First light's crosses, row by row, from the sheet's middle: the paper's targets (5.2.1)."""
CROSS_MM, CROSS_LINE_MM = 4.0, 0.3
"""A cross's arm and its line: too thin for the depth camera: its pixels are about a millimetre."""
CORNERS_MM = (120.0, 90.0)
"""First light's corners, for a surface that is found by touch; all papers have room for them."""
HOW = (
    "Print at 100 % (actual size), not 'fit to page', in black on plain paper that does not shine. "
    "The ruler must measure 100 mm."
)


def sheets() -> dict[str, bytes]:
    """Return each printable file by its name."""
    return {
        f"{name}-{paper}.pdf": document(f"halo {name}", [page(*size)])
        for name, page in (
            ("surface-sheet", _surface_sheet),
            ("anchor", _anchor),
            ("first-light", _first_light),
        )
        for paper, size in PAPERS_MM.items()
    }


def _surface_sheet(width_mm: float, height_mm: float) -> Page:
    words = "Lay it where the surface's middle shall be, then take it away."
    return _board(SHEET, words, width_mm, height_mm)


def _anchor(width_mm: float, height_mm: float) -> Page:
    words = "Fix it flat where the camera and the headset see it; it stays there."
    return _board(ANCHOR, words, width_mm, height_mm)


def _first_light(width_mm: float, height_mm: float) -> Page:
    page = Page(width_mm, height_mm)
    middle_x, middle_y = width_mm / 2.0, height_mm / 2.0
    for number, (x, y) in enumerate(CROSSES_MM):
        _cross(page, middle_x + x, middle_y + y)
        page.text(middle_x + x + 2.0, middle_y + y - 2.0, cross_name(number), 2.0)
    for side in (-1.0, 1.0):
        for end in (-1.0, 1.0):
            x, y = middle_x + side * CORNERS_MM[0], middle_y + end * CORNERS_MM[1]
            page.line(x, y, x - side * 2.0 * CROSS_MM, y, CROSS_LINE_MM)
            page.line(x, y, x, y - end * 2.0 * CROSS_MM, CROSS_LINE_MM)
    words = (
        "Tape it down before calibrating; it stays. To find the surface, lay the surface sheet "
        "exactly on it, edge on edge, and take that away again."
    )
    return _furnished(page, "halo evaluate --live", words)


def cross_name(number: int) -> str:
    """Return what a cross of first light is called: its row and column, 1-1 the far left one."""
    return f"{number // 4 + 1}-{number % 4 + 1}"


def _board(board: Printed, words: str, width_mm: float, height_mm: float) -> Page:
    page = Page(width_mm, height_mm)
    for marker in board.middles_mm:
        _draw(page, board, marker, width_mm / 2.0, height_mm / 2.0)
    return _furnished(page, _label(board), words)


def _furnished(page: Page, label: str, words: str) -> Page:
    """Add what all sheets have."""
    _arrow(page, page.width_mm / 2.0, 6.0)
    page.text(page.width_mm / 2.0 + 5.0, 10.5, f"far edge: away from you ({label})")
    _ruler(page, RULER_X_MM, page.height_mm / 2.0 - RULER_MM / 2.0)
    page.text(30.0, page.height_mm - 9.5, HOW, 2.8)
    page.text(30.0, page.height_mm - 6.0, words, 2.8)
    return page


def _label(board: Printed) -> str:
    known = list(board.middles_mm)
    numbers = f"{known[0]} to {known[-1]}" if len(known) > 1 else f"{known[0]}"
    return f"{board.family.name}, {numbers}, {board.size_mm:g} mm"


def _draw(page: Page, board: Printed, marker: int, middle_x: float, middle_y: float) -> None:
    """Draw a marker as runs of black, so that no hairlines show between its squares."""
    left, top = board.corners(marker)[0] + (middle_x, middle_y)
    side = board.size_mm / board.family.modules
    for row, squares in enumerate(marker_squares(board.family, marker)):
        turns = np.flatnonzero(np.diff(np.concatenate([[False], squares, [False]]).astype(np.int8)))
        for start, end in turns.reshape(-1, 2):
            page.box(left + start * side, top + row * side, (end - start) * side, side)


def _cross(page: Page, x: float, y: float) -> None:
    page.line(x - CROSS_MM, y, x + CROSS_MM, y, CROSS_LINE_MM)
    page.line(x, y - CROSS_MM, x, y + CROSS_MM, CROSS_LINE_MM)


def _arrow(page: Page, x: float, y: float) -> None:
    page.line(x, y, x, y + 6.0, 0.5)
    page.line(x, y, x - 2.0, y + 3.0, 0.5)
    page.line(x, y, x + 2.0, y + 3.0, 0.5)


def _ruler(page: Page, x: float, y: float) -> None:
    """A tick every 10 mm downwards; 100 mm are from the first line's middle to the last's."""
    page.line(x, y, x, y + RULER_MM)
    for tick in range(0, RULER_MM + 1, 10):
        long = tick % RULER_MM == 0
        page.line(x - (4.0 if long else 2.0), y + tick, x, y + tick)
    page.text(x - 3.5, y - 2.0, "0", 2.8)
    page.text(x - 3.5, y + RULER_MM + 4.5, f"{RULER_MM}", 2.8)
