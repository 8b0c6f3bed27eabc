"""The printable sheets: the surface's and the anchor's, at true scale on A4 and Letter.

Rule: what a sheet shows is the board that `boards` describes, around the page's middle, with a
ruler to check the print and a sentence how to print it.
"""

from __future__ import annotations

import numpy as np

from halo_calibration.boards import ANCHOR, SHEET, Printed, marker_squares
from halo_calibration.pdf import Page, document

PAPERS_MM = {"a4": (297.0, 210.0), "letter": (279.4, 215.9)}
"""Laid across."""
RULER_MM = 100
RULER_X_MM = 14.0
"""From the left edge: printers leave out up to 6 mm, and markers want a square of white."""
HOW = (
    "Print at 100 % (actual size), not 'fit to page', in black on plain paper that does not shine. "
    "The ruler must measure 100 mm."
)


def sheets() -> dict[str, bytes]:
    """Return each printable file by its name."""
    return {
        f"{name}-{paper}.pdf": document(f"halo {name}", [_page(board, words, *size)])
        for name, board, words in (
            (
                "surface-sheet",
                SHEET,
                "Lay it where the surface's middle shall be, then take it away.",
            ),
            (
                "anchor",
                ANCHOR,
                "Fix it flat where the camera and the headset see it; it stays there.",
            ),
        )
        for paper, size in PAPERS_MM.items()
    }


def _page(board: Printed, words: str, width_mm: float, height_mm: float) -> Page:
    page = Page(width_mm, height_mm)
    middle_x, middle_y = width_mm / 2.0, height_mm / 2.0
    for marker in board.middles_mm:
        _draw(page, board, marker, middle_x, middle_y)
    _arrow(page, middle_x, 6.0)
    page.text(middle_x + 5.0, 10.5, f"far edge: away from you ({_label(board)})")
    _ruler(page, RULER_X_MM, middle_y - RULER_MM / 2.0)
    page.text(30.0, height_mm - 9.5, HOW, 2.8)
    page.text(30.0, height_mm - 6.0, words, 2.8)
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
