"""`calibration`: background, the four states, the sweep, as the paper's users did it (4.3.5)."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np

from halo_service.virtual.motion import Segment, Timeline
from halo_service.virtual.room import HEIGHT_MM, WIDTH_MM, Room
from halo_service.virtual.scenario import Scenario
from halo_service.virtual.scenarios.common import away, solo

BACKGROUND_FRAMES = 75
"""A little more than the paper's 60 (4.3.1)."""
HOLD_S = 2.0
HOVER_MM, SUBTLE_MM = 10.0, 1.0
"""About 1 cm and 0.1 cm (4.3.5, figure)."""
TOUCH_G, PRESS_G, HARD_G = 25.0, 200.0, 400.0
"""A relaxed touch, a medium and a hard press, chosen."""
SWEEP_S = 20.0
SWEEP_ROWS = 6
EDGE_MM = 25.0
"""How near to the edges the sweep goes, chosen."""


def calibration(room: Room, rng: np.random.Generator) -> Scenario:
    """Ends by itself after about 45 s; its script names the steps."""
    return solo(room, rng, lambda p: _script(p, room, {"touch": TOUCH_G, "pressure": PRESS_G}))


def with_hard_press(room: Room, rng: np.random.Generator) -> Scenario:
    """The same, with a hard press after the medium one."""
    forces_g = {"touch": TOUCH_G, "pressure": PRESS_G, "hard": HARD_G}
    return solo(room, rng, lambda p: _script(p, room, forces_g))


def background_s(room: Room) -> float:
    """How long the table stays empty at first."""
    return BACKGROUND_FRAMES / room.camera().fps


def _script(p: Timeline, room: Room, forces_g: Mapping[str, float]) -> Iterator[Segment]:
    yield from p.step("background", p.hold(background_s(room)))
    middle = {"x_mm": WIDTH_MM / 2.0, "y_mm": HEIGHT_MM / 2.0, "pitch_deg": 45.0}
    yield from p.reach(1.2, **middle, height_mm=25.0)
    for name, height in (("hover", HOVER_MM), ("subtle", SUBTLE_MM)):
        yield from p.reach(0.8, height_mm=height)
        yield from p.hold(0.5)
        yield from p.step(name, p.hold(HOLD_S), height_mm=height)
        yield from p.hold(0.3)
    for name, force in forces_g.items():
        yield from p.reach(0.5, height_mm=12.0)
        yield from _held_press(p, name, force)
    yield from p.reach(0.6, height_mm=25.0)
    yield from _sweep(p)
    yield from p.reach(0.3, height_mm=20.0)
    home = away(room, p.side)
    yield from p.reach(1.0, x_mm=home.x_mm, y_mm=home.y_mm, height_mm=home.height_mm)


def _held_press(p: Timeline, name: str, force_g: float) -> Iterator[Segment]:
    """Half a second to settle, the step, a moment more; people's force wavers by 3 % (chosen)."""
    seconds = HOLD_S + 0.9
    phase = p.rng.uniform(0.0, 2.0 * np.pi)

    def force(s: float) -> float:
        waver = 1.0 + 0.03 * np.sin(2.0 * np.pi * 1.1 * s * seconds + phase)
        return force_g * min(1.0, s * seconds / 0.25) * float(waver)

    yield from p.strike(0.4)
    start_s = p.now_s + 0.5
    yield from p.press(seconds, force)
    p.note(name, start_s, start_s + HOLD_S, force_g=force_g)


def _sweep(p: Timeline) -> Iterator[Segment]:
    """Rows to and fro over the whole surface, the finger resting on the wedge."""
    x0, x1 = EDGE_MM, WIDTH_MM - EDGE_MM
    y0, y1 = EDGE_MM, HEIGHT_MM - EDGE_MM
    ways = []
    for row in range(SWEEP_ROWS):
        y = y0 + (y1 - y0) * row / (SWEEP_ROWS - 1)
        ways += [(x0, y), (x1, y)] if row % 2 == 0 else [(x1, y), (x0, y)]
    corners = np.array(ways)
    length = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(corners, axis=0).T))])
    phase = p.rng.uniform(0.0, 2.0 * np.pi, 2)

    def slide(s: float) -> dict[str, float]:
        at = s * length[-1]
        turn = 2.0 * np.pi * s
        return {
            "x_mm": float(np.interp(at, length, corners[:, 0])),
            "y_mm": float(np.interp(at, length, corners[:, 1])),
            "pitch_deg": 45.0 + 1.5 * float(np.sin(7.0 * turn + phase[0])),
            "yaw_deg": 22.0 * float(np.sin(3.0 * turn + phase[1])),
        }

    p.tool = "wedge"
    yield from p.reach(1.0, lift_mm=10.0, **(slide(0.0) | {"height_mm": 12.0}))
    yield from p.strike(0.3)
    yield from p.step("sweep", p.press(SWEEP_S, lambda _: TOUCH_G, slide), force_g=TOUCH_G)
    p.tool = None
