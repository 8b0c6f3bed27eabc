"""`crossing`: hands that work all over the table of an installation, without end.

Rule: the same motion for all cameras. A round of half a minute has its own random numbers, and
begins and ends without a hand in view, so that a camera can join at any time.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from halo_service.values import Side
from halo_service.virtual.installation.places import AREA_MM, canvas_mm, seams_mm
from halo_service.virtual.motion import Segment, Timeline, plateau, smooth
from halo_service.virtual.room import Room
from halo_service.virtual.scenario import PointingHand, Scenario, Snapshot, other
from halo_service.virtual.scenarios.common import comfortable
from halo_service.virtual.skeleton import FingerPose
from halo_service.virtual.timeline import TimelineReader

ROUND_S = 30.0
ROUNDS = 120
"""After an hour the rounds repeat."""
BACK_MM = 550.0
"""From the middle of the nearest areas to a hand that no camera sees, towards the user."""
COME_S, GO_S = 1.1, 1.0
MARGIN_MM = 28.0
"""How far fingertips stay from the canvas's edges."""
GAP_MM = (130.0, 165.0)
"""Between the fingertips of two hands: they neither touch nor hide each other."""
SPEED_MM_S = (100.0, 300.0)
"""Mean speed of a finger that crosses a seam, touching or not; the fastest moment has 1.9 times as
much. Chosen."""
BEYOND_MM = (55.0, 110.0)
"""How far from the seam a crossing begins and ends; an overlap ends 30 mm from it."""
KINDS = ("drag", "hover", "seam", "sides")
SHARES = (0.45, 0.25, 0.15, 0.15)
STEP_S = 0.25
"""A camera that joins reads the round so far in such steps."""


@dataclass(frozen=True, slots=True)
class Move:
    """What one or two hands do together: their middle's path, and when."""

    kind: str
    ends: tuple[tuple[float, float], ...]
    """Where it begins, where it goes, and so on, mm on the canvas; two or more."""
    start_s: float
    """When it begins; the hands reach the first end before."""
    leg_s: float
    """From one end to the next."""


def crossing(room: Room, rng: np.random.Generator) -> Scenario:
    """Rounds of one hand, of both, and of the other hand, in turn."""
    del rng  # each round has its own
    return Rounds(room)


class Rounds(Scenario):
    """A scenario in rounds. Times may go back by half a second, and never over a round's start
    while a hand is in view."""

    def __init__(self, room: Room) -> None:
        super().__init__(room, [])
        self._number = -1

    def at(self, t_s: float) -> Snapshot:
        """What is in view at a time."""
        number = int(t_s // ROUND_S)
        if number != self._number:
            self._begin(number, t_s)
        return super().at(t_s)

    def _begin(self, number: int, t_s: float) -> None:
        joins = number != self._number + 1
        self._number, start_s = number, number * ROUND_S
        self._motions = hands_of(self._room, number)
        if joins:  # read what happened before, so that places of later touches are right
            for before_s in np.arange(start_s, t_s, STEP_S).tolist():
                super().at(before_s)
            self.ended_contacts(t_s)


def hands_of(room: Room, number: int) -> list[PointingHand]:
    """The hands of one round."""
    sides = (
        (room.dominant,),
        (Side.LEFT, Side.RIGHT),
        (other(room.dominant),),
    )[number % 3]
    seed = (room.seed, 7, number % ROUNDS)
    gap_mm, moves = plan(room, np.random.default_rng(seed), len(sides), number * ROUND_S)
    offsets = {Side.LEFT: -gap_mm / 2.0, Side.RIGHT: gap_mm / 2.0}
    return [
        _hand(room, side, moves, offsets[side], number, np.random.default_rng((*seed, int(side))))
        for side in sides
    ]


def plan(
    room: Room, rng: np.random.Generator, hands: int, start_s: float
) -> tuple[float, list[Move]]:
    """The distance of two hands, 0 for one, and what they do in one round."""
    gap_mm = float(rng.uniform(*GAP_MM)) if hands == 2 else 0.0
    moves: list[Move] = []
    now_s, last_s = start_s + COME_S, start_s + ROUND_S - GO_S - 0.5
    while True:
        kind = str(rng.choice(KINDS, p=SHARES))
        ends = _ends(room, kind, gap_mm, rng)
        length = float(np.hypot(*(np.subtract(ends[1], ends[0]))))
        leg_s = max(0.35, length / float(rng.uniform(*SPEED_MM_S))) if kind != "seam" else 0.55
        if kind == "sides":
            leg_s += 0.5
        now_s += float(rng.uniform(0.35, 0.6))
        move = Move(kind, ends, now_s, leg_s)
        now_s += _seconds(move)
        if now_s > last_s:
            return gap_mm, moves
        moves.append(move)


def _seconds(move: Move) -> float:
    """How long a move takes; enough for the slowest strike and lift."""
    return {"hover": 0.1, "drag": 0.35}.get(move.kind, 0.6) + move.leg_s * (len(move.ends) - 1)


def _ends(
    room: Room, kind: str, gap_mm: float, rng: np.random.Generator
) -> tuple[tuple[float, float], ...]:
    """Where the middle of the hands goes: over one of the seams, there and back again."""
    seams = seams_mm(room.installation)
    size = canvas_mm(room.installation)
    axis = int(rng.integers(2)) if all(seams) else 0
    seam = float(rng.choice(seams[axis] or (size[axis] / 2.0,)))
    half_gap = gap_mm / 2.0 if axis == 0 else 0.0
    least, most = BEYOND_MM if kind != "seam" else (0.0, 25.0)
    beyond = half_gap + rng.uniform(least, most, 2)
    legs = int(rng.integers(1, 4)) if kind in ("drag", "hover") else 1
    sign = 1.0 if rng.random() < 0.5 else -1.0
    slant = rng.normal(0.0, 20.0)
    margin = np.array([MARGIN_MM + gap_mm / 2.0, MARGIN_MM])
    along = rng.uniform(margin[1 - axis], size[1 - axis] - margin[1 - axis])
    ends = []
    for number in range(legs + 1):
        side = sign * (-1.0) ** number
        place = np.empty(2)
        place[axis] = seam + side * beyond[number % 2]
        place[1 - axis] = along + side * slant
        x, y = np.clip(place, margin, np.array(size) - margin).tolist()
        ends.append((x, y))
    return tuple(ends)


def _hand(
    room: Room,
    side: Side,
    moves: Sequence[Move],
    offset_mm: float,
    number: int,
    rng: np.random.Generator,
) -> PointingHand:
    aside = 40.0 if side is Side.RIGHT else -40.0
    width, height = canvas_mm(room.installation)
    home = FingerPose(
        width / 2.0 + offset_mm + aside, height - AREA_MM[1] / 2.0 + BACK_MM, 60.0, 0.0, 40.0, 0.0
    )
    timeline = Timeline(rng, home, side)
    timeline.now_s = number * ROUND_S
    script = _script(timeline, moves, offset_mm, home)
    return PointingHand(room.user, timeline, TimelineReader(script, rng, room.seat_deg))


def _script(
    p: Timeline, moves: Sequence[Move], offset_mm: float, home: FingerPose
) -> Iterator[Segment]:
    end_s = p.now_s + ROUND_S
    for move in moves:
        ends = [(x + offset_mm, y) for x, y in move.ends]
        (x, y), height = ends[0], float(p.rng.uniform(8.0, 13.0))
        yield from p.reach(
            move.start_s - p.now_s, 10.0, x_mm=x, y_mm=y, height_mm=height, **comfortable(p)
        )
        yield from MOVES[move.kind](p, ends, move.leg_s)
    yield from p.reach(GO_S, x_mm=home.x_mm, y_mm=home.y_mm, height_mm=60.0)
    yield from p.hold(end_s - p.now_s)


Ends = Sequence[tuple[float, float]]


def _drag(p: Timeline, ends: Ends, leg_s: float) -> Iterator[Segment]:
    """Touch, slide from end to end, and lift."""
    xs, ys = zip(*ends, strict=True)

    def slide(s: float) -> dict[str, float]:
        along = s * (len(ends) - 1)
        leg = min(int(along), len(ends) - 2)
        at = leg + smooth(along - leg)
        x, y = (float(np.interp(at, range(len(ends)), part)) for part in (xs, ys))
        return {"x_mm": x, "y_mm": y}

    yield from p.strike(0.12)
    yield from p.press(leg_s * (len(ends) - 1), plateau(p.rng.uniform(50.0, 250.0), 0.15), slide)
    yield from p.reach(0.18, height_mm=14.0)


def _hover(p: Timeline, ends: Ends, leg_s: float) -> Iterator[Segment]:
    for x, y in ends[1:]:
        yield from p.reach(leg_s, x_mm=x, y_mm=y)


def _tap_twice(p: Timeline, ends: Ends, leg_s: float) -> Iterator[Segment]:
    """One tap at each end; `leg_s` holds the first tap and the way to the second."""
    begin_s = p.now_s
    yield from p.tap(p.rng.uniform(0.09, 0.15), p.rng.uniform(25.0, 150.0), lift_mm=12.0)
    (x, y), rest_s = ends[1], begin_s + leg_s - p.now_s
    yield from p.reach(rest_s, 6.0, x_mm=x, y_mm=y)
    yield from p.tap(p.rng.uniform(0.09, 0.2), p.rng.uniform(25.0, 150.0), lift_mm=12.0)


MOVES = {"drag": _drag, "hover": _hover, "seam": _tap_twice, "sides": _tap_twice}
