"""One picture of what the virtual Kinect sees, for a person to compare with the paper.

Rule: draws, and decides nothing. A row for each material, a column for each state; in each field
depth, halo (as the paper shows it: hand grey, halo white, 4.3.1), infrared and colour.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from halo_service.errors import UserError
from halo_service.files import appearing
from halo_service.values import Finger, Frame
from halo_service.virtual.curves import STATES, THRESHOLD_MM, background
from halo_service.virtual.hand import pointing
from halo_service.virtual.materials import MATERIALS
from halo_service.virtual.room import HEIGHT_MM, WIDTH_MM, Room, draw_room
from halo_service.virtual.sensor import Sensor
from halo_service.virtual.skeleton import FingerPose, PosedHand, posed

Picture = NDArray[np.uint8]

FIELD_PX = 120
"""Side of each small picture; at 0.5 m about as many millimetres."""
BORDER_PX = 22
EMPTY_FRAMES = 12


def gallery(seed: int = 1) -> Picture:
    """(H, W, 3) BGR: every material and state of one user in one place; takes about 10 s."""
    rows = [_row(draw_room(seed, material=material)) for material in MATERIALS]
    head = np.full((BORDER_PX, rows[0].shape[1], 3), 255, np.uint8)
    for column, (state, (height, force)) in enumerate(STATES.items()):
        words = f"{state}: {height:g} mm, {force:g} g"
        _write(head, words, BORDER_PX + column * (2 * FIELD_PX + BORDER_PX))
    return np.concatenate([head, *rows])


def save(path: Path, seed: int = 1) -> None:
    """Write the gallery as an image. Raises UserError where that cannot be."""
    image = gallery(seed)
    if path.suffix.lower() not in (".png", ".jpg", ".webp"):
        raise UserError(f"The gallery is a picture: name it *.png, *.jpg or *.webp, not {path}.")
    coded, data = cv2.imencode(path.suffix, image)
    assert coded, "OpenCV encodes any uint8 picture"
    try:
        with appearing(path) as file:
            file.write(data.tobytes())
    except OSError as error:
        raise UserError(f"{path} cannot be written: {error.strerror}.") from None


def _row(room: Room) -> Picture:
    sensor = Sensor(room)
    empty = background([sensor.frame(k).depth for k in range(EMPTY_FRAMES)])
    label = np.full((2 * FIELD_PX, BORDER_PX, 3), 255, np.uint8)
    turned = np.ascontiguousarray(np.rot90(label, -1))
    _write(turned, room.material, 4)
    fields = [np.rot90(turned)]
    for height, force in STATES.values():
        aim = FingerPose(WIDTH_MM / 2.0, HEIGHT_MM / 2.0, height, force)
        hand = posed(room.user, pointing(room.user, room.dominant, aim, curl=room.user.curl))
        fields += [_field(sensor, hand, empty), np.full_like(label, 255)]
    return np.concatenate(fields, axis=1)


def _field(sensor: Sensor, hand: PosedHand, empty: NDArray[np.float64]) -> Picture:
    """Four views of one state."""
    frame = sensor.frame(1_000_000, [hand])
    tip = sensor.surface.to_camera(hand.pad(Finger.INDEX)[None])
    at = sensor.camera.depth.project(tip)[0]
    views = [_grey(view, at) for view in (_depth(frame, empty), _halo(frame, empty), _ir(frame))]
    assert isinstance(frame.colour, np.ndarray) and sensor.camera.colour is not None
    seen = tip @ sensor.camera.colour_from_depth[:3, :3].T + sensor.camera.colour_from_depth[:3, 3]
    views.append(_cut(frame.colour, sensor.camera.colour.project(seen)[0]).astype(np.uint8))
    return np.concatenate([np.concatenate(views[:2], axis=1), np.concatenate(views[2:], axis=1)])


def _depth(frame: Frame, empty: NDArray[np.float64]) -> NDArray[np.float64]:
    """Nearer is brighter, 100 mm from black to white; black where nothing is measured."""
    shade = 80.0 - (frame.depth - empty) * 1.75
    return np.where(frame.depth > 0, np.maximum(shade, 1.0), 0.0)


def _halo(frame: Frame, empty: NDArray[np.float64]) -> NDArray[np.float64]:
    """Deeper than the threshold white, nearer than the noise grey."""
    measured = (frame.depth > 0) & np.isfinite(empty)
    excess = np.where(measured, frame.depth - empty, 0.0)
    return np.where(excess > THRESHOLD_MM, 255.0, np.where(excess < -THRESHOLD_MM, 127.0, 0.0))


def _ir(frame: Frame) -> NDArray[np.float64]:
    return frame.ir / 24.0


def _grey(image: NDArray[np.float64], at: NDArray[np.float64]) -> Picture:
    cut = np.clip(_cut(image, at), 0.0, 255.0).astype(np.uint8)
    return np.repeat(cut[..., None], 3, axis=2)


def _cut(image: NDArray[Any], at: NDArray[np.float64]) -> NDArray[Any]:
    """A square around a place, a little lower than it: that is where the hand is."""
    x, y = round(float(at[0])) - FIELD_PX // 2, round(float(at[1])) - FIELD_PX // 3
    return image[y : y + FIELD_PX, x : x + FIELD_PX]


def _write(image: Picture, words: str, x: int) -> None:
    place = (x, image.shape[0] - 7)
    cv2.putText(image, words, place, cv2.FONT_HERSHEY_SIMPLEX, 0.42, (0, 0, 0), 1, cv2.LINE_AA)
