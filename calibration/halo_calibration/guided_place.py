"""Guided steps that tell where things are: surface, projector and anchor.

Rule: as `guided`: the order of things and the words. Something is laid or shown, the camera looks
at it for a second, and what it saw is judged.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import Literal, Protocol

import cv2
import numpy as np

from halo_calibration import place_steps
from halo_calibration.boards import SHEET, Board, Picture, Printed, Projected, crosses
from halo_calibration.dwell import Place, dwells_for
from halo_calibration.errors import Refused
from halo_calibration.graycode import count, patterns
from halo_calibration.guided import READY_S, Cue, Guided
from halo_calibration.place_steps import View, colour_view, sheet_view
from halo_calibration.projector_solver import CROSSES
from halo_calibration.sighting import detect
from halo_calibration.steps import Change
from halo_calibration.surface_solver import CORNERS
from halo_service.geometry.camera import Camera, Points
from halo_service.profile import Profile
from halo_service.values import Frame

By = Literal["markers", "gray", "touch"]

LOOK_S = 1.0
"""How long the camera looks at a board: the mean of 30 pictures has a fifth of one's noise."""
LOOK_EVERY = 10
"""Every tenth frame of a count-down is searched for the board, to tell what is seen of it."""
TOUCHES = 3
"""Of each corner and cross."""
TOUCH_S = 30.0
"""Patience with these."""
STEADY_MM = 6.0
"""The three lie so near to their middle, or they are asked for again."""
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
        """Whether a picture is on the table at once; else somebody has to see to it."""

    def show(self, picture: Picture) -> None:
        """Show a (height, width, 3) BGR picture from now on."""


class GuidedPlace:
    """Surface, projector and anchor with a person at hand."""

    def __init__(
        self,
        guided: Guided,
        screen: Screen | None = None,
        expose: Callable[[float | None], None] | None = None,
    ) -> None:
        """`screen`: needed for the projector; `expose`: sets the colour camera's exposure in ms,
        None where that cannot be."""
        self._guided = guided
        self._screen = screen
        self._expose = expose

    def sheet(self, profile: Profile, width_mm: float, height_mm: float) -> Change:
        """Lay the surface around the printed sheet."""
        cue = Cue(
            "sheet",
            "SHEET: lay the printed surface sheet flat in the middle of your area, its upper edge "
            "away from you, and take your hands away.",
            board=SHEET,
        )
        return self._printed(
            cue,
            SHEET,
            lambda frames: place_steps.sheet_change(
                self._guided.setup, frames, profile, width_mm, height_mm
            ),
        )

    def marker(self, profile: Profile, marker: Printed) -> Change:
        """Take the pose of a printed marker."""
        cue = Cue(
            "marker",
            f"MARKER: fix {marker.name} where it shall stay, in the camera's view, and take your "
            f"hands away.",
            board=marker,
        )
        return self._printed(
            cue,
            marker,
            lambda frames: place_steps.anchor_change(self._guided.setup, frames, profile, marker),
        )

    def corners(self, profile: Profile) -> Change:
        """Lay the surface between four touched corners."""
        cues = [
            Cue(
                "corner",
                f"CORNER: touch the {name} corner of your area with the index finger, rest there "
                f"for half a second, lift it by a hand's width, {TOUCHES} times.",
                number=number,
            )
            for number, name in enumerate(CORNERS)
        ]
        return self._guided.until_good(
            lambda: place_steps.corners_change(
                self._guided.setup, self._touched(cues, profile), profile
            )
        )

    def projector(self, profile: Profile, by: By) -> Change:
        """Take the projector's place. Raises `Refused`."""
        assert self._screen is not None  # whoever asks for the projector brings one
        if by == "gray" and not self._screen.changes:
            raise Refused(
                f"Gray code needs {count(*self._screen.size_px)} pictures one after the other, "
                f"which one file cannot show: use --display, or --by markers"
            )
        ways = {"markers": self._by_board, "gray": self._by_stripes, "touch": self._by_crosses}
        with self._exposed_again():
            try:
                return self._guided.until_good(lambda: ways[by](profile, self._shown()))
            finally:
                if self._screen.changes:
                    self._screen.show(_coloured(np.zeros(self._screen.size_px[::-1], np.uint8)))

    def _by_board(self, profile: Profile, screen: Screen) -> Change:
        board = Projected(*screen.size_px)
        screen.show(_coloured(board.picture()))
        self._guided.guide.tell(
            Cue(
                "board",
                "BOARD: the projector shows a board; clear the surface, and take your hands away.",
            )
        )
        self._ready("board", board)
        self._find_exposure(board)
        frames = list(self._guided.timed("board", LOOK_S))
        return place_steps.board_change(self._guided.setup, frames, profile, board)

    def _by_stripes(self, profile: Profile, screen: Screen) -> Change:
        board = Projected(*screen.size_px)
        screen.show(_coloured(board.picture()))
        self._guided.guide.tell(
            Cue(
                "board",
                "STRIPES: the projector shows stripes for about "
                f"{count(*screen.size_px) * (SETTLE_S + GLANCE_S):.0f} seconds; clear the surface, "
                "and touch nothing.",
            )
        )
        self._ready("stripes", board)
        self._find_exposure(board)
        views = []
        for number, picture in enumerate(patterns(*screen.size_px), 1):
            screen.show(_coloured(picture))
            views.append(self._glance("stripes", f"picture {number} of {count(*screen.size_px)}"))
        return place_steps.stripes_change(self._guided.setup, views, profile, screen.size_px)

    def _by_crosses(self, profile: Profile, screen: Screen) -> Change:
        places = crosses(*screen.size_px)
        cues = [
            Cue(
                "cross",
                f"CROSS: touch the {name} cross in its middle with the index finger, rest there "
                f"for half a second, lift it by a hand's width, {TOUCHES} times.",
                at_px=(float(x), float(y)),
            )
            for name, (x, y) in zip(CROSSES, places, strict=True)
        ]
        if not screen.changes:
            screen.show(crosses_picture(screen.size_px, places))

        def lit(number: int) -> None:
            if screen.changes:
                screen.show(crosses_picture(screen.size_px, places, number))

        touches = self._touched(cues, profile, lit)
        return place_steps.crosses_change(self._guided.setup, touches, profile, screen.size_px)

    def _shown(self) -> Screen:
        assert self._screen is not None  # `projector` saw to it
        return self._screen

    def _printed(
        self, cue: Cue, board: Printed, judge: Callable[[Sequence[Frame]], Change]
    ) -> Change:
        def attempt() -> Change:
            self._guided.guide.tell(cue)
            self._ready(cue.name, board)
            return judge(list(self._guided.timed(cue.name, LOOK_S)))

        return self._guided.until_good(attempt)

    def _touched(
        self,
        cues: Sequence[Cue],
        profile: Profile,
        before: Callable[[int], None] = lambda number: None,
    ) -> list[list[Place]]:
        """Take three touches for each cue; those of one that differ are asked for again at once."""
        observer = self._guided.observer(profile)

        def one(number: int) -> list[Place]:
            before(number)
            cue, dwells = cues[number], dwells_for(profile, self._guided.setup.camera.fps)
            self._guided.guide.tell(cue)
            places: list[Place] = []
            for frame in self._guided.timed(cue.name, TOUCH_S):
                seen = observer.see(frame)
                self._guided.guide.live(self._guided.left_s, True, seen)
                place = dwells.take(seen)
                if place is not None:
                    places.append(place)
                    self._guided.guide.say(f"{len(places)} of {TOUCHES}")
                if len(places) == TOUCHES:
                    break
            _require_alike(places)
            return places

        return [
            self._guided.until_good(lambda n=number: one(n))  # type: ignore[misc]
            for number in range(len(cues))
        ]

    def _ready(self, during: str, board: Board) -> None:
        """Count down, and tell what is seen of a board."""
        words = "looking"
        for number, frame in enumerate(self._guided.timed(during, READY_S)):
            if number % LOOK_EVERY == 0:
                words = _told(frame, self._guided.setup.camera, board)
            self._guided.guide.live(self._guided.left_s, False, words)

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
            self._guided.guide.say("This source's exposure cannot be set; it is taken as it is.")
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


def _told(frame: Frame, camera: Camera, board: Board) -> str:
    """Say what of a board one frame shows."""
    view = sheet_view([frame], camera)
    seen = detect(view.picture, board)
    found = len(set(seen.numbers))
    return f"{found} of {found + len(seen.missing)} marks seen"


def _require_alike(places: Sequence[Place]) -> None:
    if len(places) < TOUCHES:
        raise Refused(
            f"only {len(places)} of {TOUCHES} touches were seen: keep the hand in the camera's "
            f"view, rest the stretched finger for half a second, lift it by a hand's width, and "
            f"touch again"
        )
    where = np.array(places)
    apart = float(np.hypot(*(where - np.median(where, axis=0)).T).max())
    if apart > STEADY_MM:
        raise Refused(
            f"the {TOUCHES} touches lie up to {apart:.0f} mm apart: touch the same mark each "
            f"time, with the finger held the same way"
        )
