"""Guided steps for places: surface and anchor.

Rule: order and prompts only, as in `guide`. A sheet is placed or a board shown, the camera
looks at it for a second, and the images are checked.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from halo_calibration.boards.board import SHEET, Board, Printed
from halo_calibration.boards.detect import detect
from halo_calibration.errors import CalibrationError
from halo_calibration.guided.guide import READY_S, GuidedCalibration, Prompt
from halo_calibration.solvers.dwell import Place, dwells_for
from halo_calibration.solvers.rigid2d import TOUCHES, steady
from halo_calibration.solvers.surface import CORNERS
from halo_calibration.steps import Change
from halo_calibration.steps import place as place_steps
from halo_calibration.steps.place import sheet_view
from halo_service.geometry.camera import Camera
from halo_service.profile import Profile
from halo_service.values import Frame

LOOK_S = 1.0
"""How long the camera looks at a board: the mean of 30 pictures has a fifth of one's noise."""
LOOK_EVERY = 10
"""Every tenth frame of a count-down is searched for the board, to report what is seen."""
TOUCH_S = 30.0
"""Patience with the touches of one corner or cross."""


class GuidedPlace:
    """Surface and anchor with a person at hand, and what the projector shares with them."""

    def __init__(self, guided: GuidedCalibration) -> None:
        self._guided = guided

    def sheet(self, profile: Profile, width_mm: float, height_mm: float) -> Change:
        """Place the surface around the printed sheet."""
        prompt = Prompt(
            "sheet",
            "SHEET: put the printed surface sheet flat in the middle of your area, its upper edge "
            "away from you, and take your hands away.",
            board=SHEET,
        )
        return self._printed(
            prompt,
            SHEET,
            lambda frames: place_steps.sheet_change(
                self._guided.setup, frames, profile, width_mm, height_mm
            ),
        )

    def marker(self, profile: Profile, marker: Printed) -> Change:
        """Calibrate the pose of a printed marker."""
        prompt = Prompt(
            "marker",
            f"MARKER: fix {marker.name} where it shall stay, in the camera's view, and take your "
            f"hands away.",
            board=marker,
        )
        return self._printed(
            prompt,
            marker,
            lambda frames: place_steps.anchor_change(self._guided.setup, frames, profile, marker),
        )

    def corners(self, profile: Profile) -> Change:
        """Lay the surface between four touched corners."""
        prompts = [
            Prompt(
                "corner",
                f"CORNER: touch the {name} corner of your area with the index finger, rest there "
                f"for half a second, lift it by a hand's width, {TOUCHES} times.",
                number=number,
            )
            for number, name in enumerate(CORNERS)
        ]
        return self._guided.until_good(
            lambda: place_steps.corners_change(
                self._guided.setup, self.touched(prompts, profile), profile
            )
        )

    def _printed(
        self, prompt: Prompt, board: Printed, solve: Callable[[Sequence[Frame]], Change]
    ) -> Change:
        def attempt() -> Change:
            self._guided.guide.prompt(prompt)
            self.ready(prompt.name, board)
            return solve(list(self._guided.timed(prompt.name, LOOK_S)))

        return self._guided.until_good(attempt)

    def touched(
        self,
        prompts: Sequence[Prompt],
        profile: Profile,
        before: Callable[[int], None] = lambda number: None,
    ) -> list[list[Place]]:
        """Record three touches per prompt; if they differ, the prompt is repeated at once."""
        observer = self._guided.observer(profile)
        # One for all: it remembers a finger that still rests on the mark before.
        dwells = dwells_for(profile, self._guided.setup.camera.fps)

        def one(number: int) -> list[Place]:
            before(number)
            prompt = prompts[number]
            self._guided.guide.prompt(prompt)
            places: list[Place] = []
            for frame in self._guided.timed(prompt.name, TOUCH_S):
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
            for number in range(len(prompts))
        ]

    def ready(self, during: str, board: Board) -> None:
        """Count down, and show how much of a board is seen."""
        words = "looking"
        for number, frame in enumerate(self._guided.timed(during, READY_S)):
            if number % LOOK_EVERY == 0:
                words = _board_status(frame, self._guided.setup.camera, board)
            self._guided.guide.live(self._guided.left_s, False, words)


def _board_status(frame: Frame, camera: Camera, board: Board) -> str:
    """Say what of a board one frame shows."""
    view = sheet_view([frame], camera)
    seen = detect(view.picture, board)
    found = len(set(seen.numbers))
    return f"{found} of {found + len(seen.missing)} marks seen"


def _require_alike(places: Sequence[Place]) -> None:
    if len(places) < TOUCHES:
        raise CalibrationError(
            f"only {len(places)} of {TOUCHES} touches were seen: keep the hand in the camera's "
            f"view, rest the stretched finger for half a second, lift it by a hand's width, and "
            f"touch again"
        )
    steady("the mark", np.array(places))
