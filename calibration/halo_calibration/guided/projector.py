"""The guided projector step: it shows a board, stripes or crosses, and the camera looks at them.

Rule: order and prompts only, as in `guide`.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Protocol

import cv2
import numpy as np

from halo_calibration.boards.board import Picture, Projected, crosses
from halo_calibration.boards.detect import detect
from halo_calibration.boards.graycode import count, patterns
from halo_calibration.errors import CalibrationError
from halo_calibration.guided.guide import GuidedCalibration, Prompt
from halo_calibration.guided.place import LOOK_S, GuidedPlace
from halo_calibration.solvers.projector import CROSSES
from halo_calibration.solvers.rigid2d import TOUCHES
from halo_calibration.steps import Change
from halo_calibration.steps import place as place_steps
from halo_calibration.steps.place import View, colour_view
from halo_service.geometry.camera import Points
from halo_service.profile import Profile

EXPOSURES_MS = (30.0, 16.0, 8.0, 4.0, 2.0, 1.0)
"""Tried in turn: from what a dim room needs to what a bright projector in one needs."""
SETTLE_S, GLANCE_S = 0.3, 0.1
"""From a new picture or exposure to a frame that shows it (a projector and the two cameras' queues
take up to a quarter of a second), and how long is then looked."""
BLOWN, BLOWN_SHARE = 250, 0.01
"""Grey level from which a pixel is blown out, and the share of them that is too many."""
DIM, LIT, PAPER = 110, 255, 0
"""Grey levels of the other crosses, the one to touch, and what is around them."""


class Screen(Protocol):
    """What shows pictures on the table: a projector's display, or a file that one shows there."""

    @property
    def size_px(self) -> tuple[int, int]:
        """Width and height of its pictures."""

    @property
    def changes(self) -> bool:
        """Whether a picture appears on the table at once; else the user has to show it."""

    def show(self, picture: Picture) -> None:
        """Show a (height, width, 3) BGR picture from now on."""


class GuidedProjector:
    """The projector with a person at hand."""

    def __init__(
        self,
        guided: GuidedCalibration,
        screen: Screen,
        expose: Callable[[float | None], None] | None = None,
    ) -> None:
        """`expose` sets the colour camera's exposure in ms; None where that cannot be."""
        self._guided = guided
        self._place = GuidedPlace(guided)
        self._screen = screen
        self._expose = expose

    def projector(self, profile: Profile, by: str) -> Change:
        """Calibrate the projector, by `markers`, `gray` or `touch`. Raises `CalibrationError`."""
        if by == "gray" and not self._screen.changes:
            raise CalibrationError(
                f"Gray code needs {count(*self._screen.size_px)} pictures one after the other, "
                f"which one file cannot show: use --display, or --by markers"
            )
        ways = {"markers": self._by_board, "gray": self._by_stripes, "touch": self._by_crosses}
        with self._exposed_again():
            try:
                return self._guided.until_good(lambda: ways[by](profile))
            finally:
                if self._screen.changes:
                    self._screen.show(_coloured(np.zeros(self._screen.size_px[::-1], np.uint8)))

    def _by_board(self, profile: Profile) -> Change:
        board = self._board_shown(
            "BOARD: the projector shows a board; clear the surface, and take your hands away."
        )
        frames = list(self._guided.timed("board", LOOK_S))
        return place_steps.board_change(self._guided.setup, frames, profile, board)

    def _by_stripes(self, profile: Profile) -> Change:
        size_px = self._screen.size_px
        every = count(*size_px)
        self._board_shown(
            f"STRIPES: the projector shows a board, then stripes for about "
            f"{every * (SETTLE_S + GLANCE_S):.0f} seconds; clear the surface, and touch nothing."
        )
        views = []
        for number, picture in enumerate(patterns(*size_px), 1):
            self._screen.show(_coloured(picture))
            views.append(self._glance("stripes", f"picture {number} of {every}"))
        return place_steps.stripes_change(self._guided.setup, views, profile, size_px)

    def _board_shown(self, words: str) -> Projected:
        """Show the board and expose for it: the stripes are as bright, and may be read where it
        is not."""
        board = Projected(*self._screen.size_px)
        self._screen.show(_coloured(board.picture()))
        self._guided.guide.prompt(Prompt("board", words))
        self._place.ready("board", board)
        self._find_exposure(board)
        return board

    def _by_crosses(self, profile: Profile) -> Change:
        places = crosses(*self._screen.size_px)
        prompts = [
            Prompt(
                "cross",
                f"CROSS: touch the {name} cross in its middle with the index finger, rest there "
                f"for half a second, lift it by a hand's width, {TOUCHES} times.",
                at_px=(float(x), float(y)),
            )
            for name, (x, y) in zip(CROSSES, places, strict=True)
        ]
        if not self._screen.changes:
            self._screen.show(crosses_picture(self._screen.size_px, places))

        def lit(number: int) -> None:
            if self._screen.changes:
                self._screen.show(crosses_picture(self._screen.size_px, places, number))

        touches = self._place.touched(prompts, profile, lit)
        return place_steps.crosses_change(
            self._guided.setup, touches, profile, self._screen.size_px
        )

    def _glance(self, during: str, words: str) -> View:
        """Let a new picture or exposure settle, and look at it."""
        frames = []
        for frame in self._guided.timed(during, SETTLE_S + GLANCE_S):
            self._guided.guide.live(self._guided.left_s, True, words)
            if self._guided.left_s <= GLANCE_S:
                frames.append(frame)
        return colour_view(frames, self._guided.setup.camera)

    def _find_exposure(self, board: Projected) -> None:
        """Fix the exposure at which most of the board is read, and least is blown out."""
        if self._expose is None:
            self._guided.guide.say("This source's exposure cannot be set; it stays as it is.")
            return
        best: tuple[int, float] | None = None
        chosen = EXPOSURES_MS[0]
        for exposure_ms in EXPOSURES_MS:
            self._expose(exposure_ms)
            picture = self._glance("exposure", f"exposure {exposure_ms:g} ms").picture
            read = (len(detect(picture, board).numbers), _exposed(picture))
            if best is None or read > best:
                best, chosen = read, exposure_ms
        self._expose(chosen)
        self._glance("exposure", f"exposure {chosen:g} ms")
        self._guided.guide.say(f"Exposure: {chosen:g} ms.")

    @contextmanager
    def _exposed_again(self) -> Iterator[None]:
        """Leave the exposure to the camera in the end."""
        try:
            yield
        finally:
            if self._expose is not None:
                self._expose(None)


def crosses_picture(size_px: tuple[int, int], places: Points, lit: int | None = None) -> Picture:
    """(height, width, 3) the crosses to touch; all are lit where none is named."""
    width, height = size_px
    picture = np.full((height, width), PAPER, np.uint8)
    arm = height // 24
    for number, place in enumerate(places):
        # Lines of an even width lie around the corner of pixels that the place is.
        x, y = round(float(place[0])), round(float(place[1]))
        level = LIT if lit is None or number == lit else DIM
        picture[y - arm : y + arm, x - 2 : x + 2] = level
        picture[y - 2 : y + 2, x - arm : x + arm] = level
    return _coloured(picture)


def _coloured(picture: Picture) -> Picture:
    return np.asarray(cv2.cvtColor(picture, cv2.COLOR_GRAY2BGR), dtype=np.uint8)


def _exposed(picture: Picture) -> float:
    """How well a picture is exposed, 0 to 1; less than 0 where too much of it is blown out."""
    grey = cv2.cvtColor(picture, cv2.COLOR_BGR2GRAY)
    blown = float(np.mean(grey >= BLOWN))
    return -blown if blown > BLOWN_SHARE else float(np.mean(grey)) / 255.0
