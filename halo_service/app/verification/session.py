"""One verification: draws the grid, prints and counts the touches, from any source of touches."""

from __future__ import annotations

import sys
from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from halo_calibration.guided.projector import Screen
from halo_service.app.projector.display import Display
from halo_service.app.verification.crossings import Finger, Grid, Landing
from halo_service.errors import UserError
from halo_service.profile import StepRecord


def _print(words: str) -> None:
    print(words, file=sys.stderr)


class Verification:
    """One grid, until all of its crossings are touched."""

    def __init__(
        self,
        grid: Grid,
        screen: Screen,
        say: Callable[[str], None] = _print,
        watch: Callable[[Grid], None] = lambda grid: None,
    ) -> None:
        """`say`: gets a line for each touch; `watch`: is called in each frame."""
        self.grid = grid
        self._say, self._watch = say, watch
        self._screen = screen
        self._screen.show(grid.picture([]))

    def update(self, fingers: Sequence[Finger], downs: Sequence[tuple[float, float]]) -> None:
        """Draw one frame and count the touches that begin in it; mm on the surface."""
        self._watch(self.grid)
        for x_mm, y_mm in downs:
            landing = self.grid.land(x_mm, y_mm)
            missed = f"a touch at {x_mm:.0f}, {y_mm:.0f} mm is not near a crossing"
            self._say(missed if landing is None else landing_line(self.grid, landing))
        self._screen.show(self.grid.picture(fingers))

    @property
    def done(self) -> bool:
        """True when nothing is left to touch, or the user closed the display."""
        closed = isinstance(self._screen, Display) and not self._screen.open
        return closed or self.grid.next is None


def landing_line(grid: Grid, landing: Landing) -> str:
    """Return how far a touch is from its crossing, mm and px."""
    right, near = f"{landing.dx_mm:+.1f} right", f"{landing.dy_mm:+.1f} near"
    off = f"{landing.off_mm:.1f} mm off, {grid.off_px(landing):.1f} px"
    return f"{grid.name(landing.crossing)}: {off} ({right}, {near})"


def grid_over(
    width_mm: float,
    height_mm: float,
    matrix: NDArray[np.float64],
    size_px: tuple[int, int],
    screen: Screen,
) -> Grid:
    """Make a grid over a surface for a screen, which may differ in size from the calibrated one
    (`size_px`); `matrix`: `projector_from_surface`. Raises `UserError` if no crossing fits."""
    scale = np.diag([screen.size_px[0] / size_px[0], screen.size_px[1] / size_px[1], 1.0])
    grid = Grid(width_mm, height_mm, scale @ matrix, screen.size_px)
    if len(grid.places) == 0:
        raise UserError(
            "the picture of the projector does not reach the surface: move the projector, then run "
            "'halo calibrate projector' again"
        )
    return grid


def print_summary(grid: Grid, within_mm: float) -> int:
    """Print the figures; return the exit code: 0 if all crossings were touched and 95 % of the
    touches are within the bound."""
    lines, good = summary_lines(grid, within_mm)
    print("\n".join(lines))
    return int(not good)


def summary_lines(grid: Grid, within_mm: float) -> tuple[list[str], bool]:
    """Return the figures as lines, and whether the verification is passed."""
    summary = grid.summary()
    if summary is None:
        return ["failed: no crossing was touched"], False
    figures = (
        f"{summary.touches} touches of {summary.crossings} of {len(grid.places)} crossings: median "
        f"{summary.median_mm:.1f} mm, p95 {summary.p95_mm:.1f} mm, worst "
        f"{summary.worst_mm:.1f} mm at {grid.name(summary.worst)}"
    )
    good = summary.p95_mm <= within_mm and summary.crossings == len(grid.places)
    result = "passed" if good else "failed"
    return [figures, f"{result}: touch all crossings, 95 % within {within_mm:g} mm"], good


def verify_record(grid: Grid, date: str) -> StepRecord | None:
    """Return what a profile stores of a verification; None before the first touch."""
    summary = grid.summary()
    if summary is None:
        return None
    figures = {
        "touches": summary.touches,
        "crossings": summary.crossings,
        "median_mm": summary.median_mm,
        "p95_mm": summary.p95_mm,
        "worst_mm": summary.worst_mm,
    }
    rounded = {name: round(float(value), 2) for name, value in figures.items()}
    return StepRecord(date, "good", rounded, f"the worst is {grid.name(summary.worst)}")
