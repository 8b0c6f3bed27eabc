"""Finding hands: MediaPipe's Hand Landmarker on one picture after the other.

Rule: everything that knows MediaPipe's interface lives here. It follows a hand from one picture
to the next, so the pictures given to one tracker are one film; the same film gives the same
hands. Importing this takes a second: do it only where hands are looked for.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from mediapipe import Image, ImageFormat
from mediapipe.tasks.python import BaseOptions, vision
from mediapipe.tasks.python.components.containers.landmark import NormalizedLandmark

from halo_service.errors import UserError
from halo_service.hand_tracking.blend import Picture
from halo_service.hand_tracking.quiet import without_known_noise
from halo_service.values import Hand, Pixels, Side, Tracked

# A right hand seen from above, palm down, is called "Right": no mirror as in a webcam's picture.
_SIDES = {"Left": Side.LEFT, "Right": Side.RIGHT}
_US_PER_MS = 1000


class HandTracker:
    """Hands in one film of pictures. Used from one thread at a time."""

    def __init__(self, model_path: Path, max_hands: int = 2) -> None:
        """Load the model (0.2 s); raises UserError for a file that is no Hand Landmarker.

        `max_hands`: 1 or more, ValueError otherwise.
        """
        if max_hands < 1:
            raise ValueError(f"max_hands must be 1 or more, not {max_hands}")
        options = vision.HandLandmarkerOptions(
            base_options=BaseOptions(
                model_asset_path=str(model_path), delegate=BaseOptions.Delegate.CPU
            ),
            running_mode=vision.RunningMode.VIDEO,
            num_hands=max_hands,
        )
        self._stamp_ms = 0
        with without_known_noise():
            try:
                self._landmarker = vision.HandLandmarker.create_from_options(options)
            except (RuntimeError, ValueError, OSError) as error:
                raise UserError(
                    f"the hand model {model_path} cannot be loaded ({_first_line(error)}); "
                    "correct `tracking.model`, or leave the key out"
                ) from error
            # The first picture costs more and says more than all others: get it over with.
            self.find(np.zeros((64, 64, 3), np.uint8), 0)

    def find(self, picture: Picture, time_us: int) -> Tracked:
        """Find the hands in `picture`, (H, W, 3) uint8 RGB, and give them in its pixels."""
        # MediaPipe wants time to rise by 1 ms at least; where ours does not (a jump back), it
        # gets the next millisecond, for it uses time to tell pictures apart, and for no more.
        self._stamp_ms = max(self._stamp_ms + 1, time_us // _US_PER_MS)
        image = Image(image_format=ImageFormat.SRGB, data=np.ascontiguousarray(picture))
        found = self._landmarker.detect_for_video(image, self._stamp_ms)
        height, width = picture.shape[:2]
        hands = (
            Hand(
                side=_SIDES.get(handedness[0].category_name, Side.UNKNOWN),
                landmarks_px=to_pixels(landmarks, width, height),
                confidence=float(handedness[0].score),
            )
            for handedness, landmarks in zip(found.handedness, found.hand_landmarks, strict=True)
        )
        return Tracked(time_us, tuple(hands))

    def close(self) -> None:
        """Let the model go."""
        self._landmarker.close()


def to_pixels(landmarks: list[NormalizedLandmark], width: int, height: int) -> Pixels:
    """(21, 2): MediaPipe's 0 and 1 are the picture's outer edges, our pixels count centres."""
    relative = np.array([(mark.x, mark.y) for mark in landmarks], dtype=np.float64)
    return relative * (width, height) - 0.5


def _first_line(error: Exception) -> str:
    """What MediaPipe says, without the source lines that it puts after it."""
    return str(error).strip().partition("\n")[0]
