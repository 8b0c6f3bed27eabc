"""One picture of what the virtual camera sees, for a person to compare with the paper.

Rule: draws, and decides nothing. A row for each material, then one for each kind of halo and hand
on paper; a column for each state; in each field depth, halo (as the paper shows it: hand grey, halo
white, 4.3.1), infrared and colour.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
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
from halo_service.virtual.sensor_model import TRUE, SensorModel
from halo_service.virtual.skeleton import FingerPose, PosedHand, posed

Picture = NDArray[np.uint8]

FIELD_PX = 120
"""Side of each small picture; at 0.5 m about as many millimetres."""
BORDER_PX, CAPTION_PX = 22, 18
EMPTY_FRAMES, FRAMES = 12, 6
VARIANTS: dict[str, Mapping[str, object]] = {
    "odd halo": {
        "curve.shift_mm": 4.0, "curve.stretch": 1.6, "curve.lopsided": 0.3, "curve.glow_mm": 2.0,
    },
    "hanging": {"user.curl": 0.0, "user.thumb_out": 1.0},
    "nails, ring": {"user.nail_over_mm": 6.0, "user.rings": (Finger.INDEX,)},
    "from the left": {"seat_deg": 90.0, "user.sleeve_mm": -30.0},
}  # fmt: skip
"""Halos and hands of one user on paper, by name."""
LEGEND = (
    "Each field: top depth (near is bright) and halo (white: farther than the empty table by more",
    "than the > in brackets; grey: nearer), below: infrared and colour. Black: no depth. Hover:",
    "the greatest height at which the halo shows, up to 20 mm, as the paper defines it (4.3.5).",
)
THRESHOLDS_MM = (THRESHOLD_MM, 5.0)
"""The paper's, and its smallest, for weak materials (4.3.1)."""
HOVERS_MM = 3, 21
"""Heights between which hover is looked for; the upper one is not tried."""
SHOWS_PX = 12
"""So many white pixels can be seen."""


def gallery(seed: int = 1, sensor: SensorModel = TRUE) -> Picture:
    """(H, W, 3) BGR: each material, halo and hand in each state; takes about 20 s."""
    rooms = {material: draw_room(seed, material=material, sensor=sensor) for material in MATERIALS}
    rooms |= {
        name: draw_room(seed, material="paper", sensor=sensor, **changes)
        for name, changes in VARIANTS.items()
    }
    rows = [_row(name, room) for name, room in rooms.items()]
    head = _white(BORDER_PX * (len(LEGEND) + 1), rows[0].shape[1])
    for line, words in enumerate(LEGEND):
        _write(head, words, BORDER_PX, BORDER_PX * (line + 1))
    return np.concatenate([head, *rows])


def save(path: Path, seed: int = 1, sensor: SensorModel = TRUE) -> None:
    """Write the gallery as an image. Raises UserError where that cannot be."""
    if path.suffix.lower() not in (".png", ".jpg", ".webp"):
        raise UserError(f"The gallery is a picture: name it *.png, *.jpg or *.webp, not {path}.")
    try:
        # Opened first: a folder that does not exist is an error before 20 s of drawing.
        with appearing(path) as file:
            coded, data = cv2.imencode(path.suffix, gallery(seed, sensor))
            assert coded, "OpenCV encodes any uint8 picture"
            file.write(data.tobytes())
    except OSError as error:
        raise UserError(f"{path} cannot be written: {error.strerror}.") from None


class _View:
    """One room, its empty table, and pictures of a hand over it."""

    def __init__(self, room: Room) -> None:
        self._room, self._sensor = room, Sensor(room)
        self._bare = Sensor(dataclasses.replace(room, projected=None), colour_times=0)
        self._empty = background([self._bare.frame(k).depth for k in range(EMPTY_FRAMES)])

    def hand(self, height_mm: float, force_g: float) -> PosedHand:
        """The user's hand, its fingertip over the middle."""
        room = self._room
        middle = WIDTH_MM / 2.0, HEIGHT_MM / 2.0
        aim = FingerPose(*middle, height_mm, force_g, 45.0, room.seat_deg)
        return posed(room.user, pointing(room.user, room.dominant, aim, curl=room.user.curl))

    def hover_mm(self, threshold_mm: float) -> int | None:
        """The greatest height at which the halo shows, in whole mm; None: at no height."""
        low, high = HOVERS_MM
        if not self._shows(low, threshold_mm):
            return None
        while high - low > 1:
            middle = (low + high) // 2
            low, high = (middle, high) if self._shows(middle, threshold_mm) else (low, middle)
        return low

    def _shows(self, height_mm: int, threshold_mm: float) -> bool:
        hand = self.hand(height_mm, 0.0)
        excess = self._cut(_excess(self._mean(hand), self._empty), hand)
        return bool(np.count_nonzero(excess > threshold_mm) >= SHOWS_PX)

    def field(self, hand: PosedHand, threshold_mm: float) -> Picture:
        """(2 FIELD_PX, 2 FIELD_PX, 3) four views of one state."""
        frame, depth = self._sensor.frame(1_000_000, [hand]), self._mean(hand)
        shades = (
            _depth(frame, self._empty),
            _halo(depth, self._empty, threshold_mm),
            frame.ir / 24.0,
        )
        views = [_grey(self._cut(shade, hand)) for shade in shades]
        assert isinstance(frame.colour, np.ndarray)
        views.append(_square(frame.colour, self._colour_px(hand)).astype(np.uint8))
        upper, lower = np.concatenate(views[:2], axis=1), np.concatenate(views[2:], axis=1)
        return np.concatenate([upper, lower])

    def _mean(self, hand: PosedHand) -> NDArray[np.float64]:
        """(H, W) mean depth of some frames, so that noise does not count as halo."""
        return background([self._bare.frame(1_000_000 + k, [hand]).depth for k in range(FRAMES)])

    def _tip(self, hand: PosedHand) -> NDArray[np.float64]:
        return self._sensor.surface.to_camera(hand.pad(Finger.INDEX)[None])

    def _cut(self, image: NDArray[Any], hand: PosedHand) -> NDArray[Any]:
        return _square(image, self._sensor.camera.depth.project(self._tip(hand))[0])

    def _colour_px(self, hand: PosedHand) -> NDArray[np.float64]:
        camera = self._sensor.camera
        assert camera.colour is not None
        turn = camera.colour_from_depth
        seen = self._tip(hand) @ turn[:3, :3].T + turn[:3, 3]
        return np.asarray(camera.colour.project(seen)[0], dtype=np.float64)


def _row(name: str, room: Room) -> Picture:
    view = _View(room)
    label = _white(2 * FIELD_PX + CAPTION_PX, BORDER_PX)
    turned = np.ascontiguousarray(np.rot90(label, -1))
    _write(turned, name, 4, BORDER_PX)
    parts = [np.rot90(turned)]
    for threshold_mm in THRESHOLDS_MM:
        hover_mm = view.hover_mm(threshold_mm)
        if hover_mm is not None:
            break
    for state, (height_mm, force_g) in STATES.items():
        words = f"{state}: {height_mm:g} mm, {force_g:g} g (> {threshold_mm:g} mm)"
        if state == "hover":
            height_mm = height_mm if hover_mm is None else hover_mm
            shows = "no halo" if hover_mm is None else f"(> {threshold_mm:g} mm)"
            words = f"{state}: {height_mm:g} mm {shows}"
        caption = _white(CAPTION_PX, 2 * FIELD_PX)
        _write(caption, words, 0, CAPTION_PX)
        parts += [
            np.concatenate([caption, view.field(view.hand(height_mm, force_g), threshold_mm)]),
            np.full_like(label, 255),
        ]
    return np.concatenate(parts, axis=1)


def _excess(depth: NDArray[np.float64], empty: NDArray[np.float64]) -> NDArray[np.float64]:
    measured = np.isfinite(depth) & np.isfinite(empty)
    return np.where(measured, np.where(measured, depth, 0.0) - np.where(measured, empty, 0.0), 0.0)


def _depth(frame: Frame, empty: NDArray[np.float64]) -> NDArray[np.float64]:
    """Nearer is brighter, 100 mm from black to white; black where nothing is measured."""
    shade = 80.0 - (frame.depth - empty) * 1.75
    return np.where(frame.depth > 0, np.maximum(shade, 1.0), 0.0)


def _halo(
    depth: NDArray[np.float64], empty: NDArray[np.float64], threshold_mm: float
) -> NDArray[np.float64]:
    """Deeper than the threshold white, nearer than the noise grey."""
    excess = _excess(depth, empty)
    return np.where(excess > threshold_mm, 255.0, np.where(excess < -threshold_mm, 127.0, 0.0))


def _grey(image: NDArray[np.float64]) -> Picture:
    return np.repeat(np.clip(image, 0.0, 255.0).astype(np.uint8)[..., None], 3, axis=2)


def _square(image: NDArray[Any], at: NDArray[np.float64]) -> NDArray[Any]:
    """A square around a place, a little lower than it: that is where most hands are."""
    x, y = round(float(at[0])) - FIELD_PX // 2, round(float(at[1])) - FIELD_PX // 3
    return image[y : y + FIELD_PX, x : x + FIELD_PX]


def _white(rows: int, columns: int) -> Picture:
    return np.full((rows, columns, 3), 255, np.uint8)


def _write(image: Picture, words: str, x: int, below: int) -> None:
    place = (x, below - 7)
    cv2.putText(image, words, place, cv2.FONT_HERSHEY_SIMPLEX, 0.42, (0, 0, 0), 1, cv2.LINE_AA)
