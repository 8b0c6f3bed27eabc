"""From frames to gestures: hits, presses and the height of the other hand.

Rule: pure. Frames come in, gestures go out; each has its time on the frames' clock.
A tap is a `Hit`; a touch that stays is a `Press`; the height of the hand that does not drum is a
`Shape`.
"""

from __future__ import annotations

from dataclasses import dataclass

from halo_client import Began, Ended, TouchKey, touches
from halo_client.strike import loudness
from halo_drums.kit import KIT, Pad, Settings, pad_at
from halo_protocol import Hand, Pointer, TouchFrame


@dataclass(frozen=True, slots=True)
class Hit:
    """A pad was struck."""

    time_us: int
    key: TouchKey
    pad: Pad
    level: float
    """Loudness, above 0 to 1."""
    u: float
    v: float


@dataclass(frozen=True, slots=True)
class Press:
    """The finger that struck stays and presses; 0 when it is lifted."""

    time_us: int
    key: TouchKey
    amount: float
    """1 at the calibrated medium press, at most 1.5."""


@dataclass(frozen=True, slots=True)
class Release:
    """The finger was lifted."""

    time_us: int
    key: TouchKey


@dataclass(frozen=True, slots=True)
class Shape:
    """How high the other hand hovers."""

    time_us: int
    height: float
    """0 low: deep; 1 high: sharp."""


Gesture = Hit | Press | Release | Shape
HandKey = tuple[str, str, str, int, int]
"""Node, surface, session, hand, finger id. The id is -1 if the hand is known."""


class Player:
    """Remembers which hand drums and which touches are active."""

    def __init__(self, kit: tuple[Pad, ...] = KIT, settings: Settings | None = None) -> None:
        self._kit = kit
        self._settings = settings or Settings()
        self._since_us: dict[TouchKey, int] = {}
        self._struck_us: dict[HandKey, int] = {}
        self._drummer: HandKey | None = None

    def process(self, frame: TouchFrame) -> list[Gesture]:
        """Return the gestures of a frame."""
        gestures: list[Gesture] = []
        for touch in touches(frame):
            if isinstance(touch, Began):
                gestures.append(self._hit(frame, touch))
            elif isinstance(touch, Ended):
                self._since_us.pop(touch.key, None)
                gestures.append(Release(touch.time_us, touch.key))
            elif self._lasts(touch.key, touch.time_us):
                amount = min(touch.pointer.pressure, 1.5)
                gestures.append(Press(touch.time_us, touch.key, amount))
        shape = self._shape(frame)
        return [*gestures, shape] if shape else gestures

    def _hit(self, frame: TouchFrame, touch: Began) -> Hit:
        self._since_us[touch.key] = touch.time_us
        if touch.pointer is not None:
            self._drummer = _hand_key(frame, touch.pointer)
            self._struck_us[self._drummer] = frame.time_us
        down = touch.down
        pad = pad_at(self._kit, down.u, down.v)
        level = loudness(down.strike_mm_s, self._settings.soft, self._settings.loud_mm_s)
        return Hit(touch.time_us, touch.key, pad, level, down.u, down.v)

    def _lasts(self, key: TouchKey, now_us: int) -> bool:
        began_us = self._since_us.setdefault(key, now_us)
        return now_us - began_us > self._settings.hold_s * 1e6

    def _shape(self, frame: TouchFrame) -> Shape | None:
        """The lowest finger of a hand that does not drum; None before the first hit."""
        heights = [
            pointer.hover_mm
            for pointer in frame.pointers
            if not pointer.touching and self._rests(_hand_key(frame, pointer), frame.time_us)
        ]
        if not heights:
            return None
        low_mm, high_mm = self._settings.low_mm, self._settings.high_mm
        height = (min(heights) - low_mm) / (high_mm - low_mm)
        return Shape(frame.time_us, min(max(height, 0.0), 1.0))

    def _rests(self, hand: HandKey, now_us: int) -> bool:
        if self._drummer is None or hand == self._drummer:
            return False
        struck_us = self._struck_us.get(hand)
        return struck_us is None or now_us - struck_us > self._settings.rest_s * 1e6


def _hand_key(frame: TouchFrame, pointer: Pointer) -> HandKey:
    hand, finger = pointer.hand, pointer.id if pointer.hand == Hand.UNKNOWN else -1
    return (frame.node, frame.surface, frame.session, hand, finger)
