"""Find hands: MediaPipe's Hand Landmarker on one image after the other.

Rule: only this module knows MediaPipe's interface. It follows a hand from one image to the next,
so one tracker gets one video; the same video gives the same hands. The import takes half a second:
do it only where hands are needed.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from halo_service.errors import UserError
from halo_service.hand_tracking.blend import Picture
from halo_service.hand_tracking.quiet import without_known_noise, without_plotting
from halo_service.values import Hand, Pixels, Side, Tracked

with without_plotting():
    from mediapipe import Image, ImageFormat
    from mediapipe.tasks.python import BaseOptions, vision
    from mediapipe.tasks.python.components.containers.landmark import NormalizedLandmark

# A right hand seen from above, palm down, is called "Right": no mirror as in a webcam's image.
_SIDES = {"Left": Side.LEFT, "Right": Side.RIGHT}
_SYSTEM_LIBRARIES = {"libEGL": "libegl1", "libGLESv2": "libgles2", "libGL.": "libgl1"}
"""And Debian's package of each."""
_US_PER_MS = 1000


class HandTracker:
    """Hands in one video. Used from one thread at a time."""

    def __init__(self, model_path: Path, max_hands: int = 2) -> None:
        """Load the model (0.2 s); raises UserError if the file is not a Hand Landmarker.

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
                    f"{_remedy(str(error))}"
                ) from error
            # The first image is slow and prints warnings: do it here.
            self.find(np.zeros((64, 64, 3), np.uint8), 0)

    def find(self, picture: Picture, time_us: int) -> Tracked:
        """Find the hands in `picture`, (H, W, 3) uint8 RGB; landmarks are in its pixels."""
        # MediaPipe needs times that rise by at least 1 ms; where ours do not (a jump back), it
        # gets the next millisecond: it uses time only to distinguish images.
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
        """Free the model."""
        self._landmarker.close()


def to_pixels(landmarks: list[NormalizedLandmark], width: int, height: int) -> Pixels:
    """(21, 2): MediaPipe's 0 and 1 are the image's outer edges, our pixels count centres."""
    relative = np.array([(mark.x, mark.y) for mark in landmarks], dtype=np.float64)
    return relative * (width, height) - 0.5


def _remedy(reason: str) -> str:
    """Return what to do: MediaPipe needs libraries of the system that slim containers lack."""
    missing = [package for library, package in _SYSTEM_LIBRARIES.items() if library in reason]
    if missing:
        return f"install the system's library: on Debian and Ubuntu 'apt install {missing[0]}'"
    return "correct `tracking.model`, or leave the key out"


def _first_line(error: Exception) -> str:
    """MediaPipe's message, without the source lines after it."""
    return str(error).strip().partition("\n")[0]
