"""What the owner of a camera does in a session: touches, heights and forces. Pure."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any, Literal

from halo_calibration.boards.sheets import CROSSES_MM, cross_name
from halo_calibration.guided.guide import Prompt
from halo_service.errors import UserError
from halo_service.geometry.surface import Surface
from halo_service.virtual.scenarios.study import FORCES_G, HEIGHTS_MM

Kind = Literal["touch", "tap", "hover", "pressure"]
ROUNDS = 2
"""Levels are held twice each, as in the paper (5.2.2)."""
BRIEF_CROSSES = (0, 3, 12, 15)
"""The crosses of a brief session: the outer corners."""


@dataclass(frozen=True, slots=True)
class Task:
    """One thing to do."""

    kind: Kind
    prompt: Prompt
    step: str
    """Its name in the script."""
    fields: dict[str, Any] = field(default_factory=dict)
    """More fields of its line in the script."""


@dataclass(frozen=True, slots=True)
class PlanOptions:
    """What is there to work with."""

    heights_mm: Sequence[float] = HEIGHTS_MM
    """Of the pegs, or of stacks of coins."""
    coins: bool = False
    """Heights are stacks of coins under the finger's middle joint."""
    forces_g: Sequence[float] = FORCES_G
    """What the scale shall show; empty: there is no scale."""
    brief: bool = False
    """Four crosses, two heights, two forces, once each."""

    def __post_init__(self) -> None:
        """Check the levels. Raises `UserError`."""
        if not all(0.5 <= each <= 40.0 for each in self.heights_mm):
            raise UserError("first-light: heights must be in range 0.5..40 mm")
        if not all(10.0 <= each <= 1000.0 for each in self.forces_g):
            raise UserError("first-light: forces must be in range 10..1000 g")


def tasks_of(surface: Surface, options: PlanOptions) -> Iterator[Task]:
    """Yield the session; the crosses lie around the surface's middle."""
    numbers = BRIEF_CROSSES if options.brief else tuple(range(len(CROSSES_MM)))
    kinds: tuple[Kind, Kind] = ("touch", "tap")
    for kind in kinds:
        yield from (_cross(kind, number, surface) for number in numbers)
    heights, forces = tuple(options.heights_mm), tuple(options.forces_g)
    if options.brief:
        heights, forces = heights[1:4:2], forces[1:4:2]
    for _ in range(1 if options.brief else ROUNDS):
        yield from (_height(each, options.coins) for each in heights)
        yield from (_force(each) for each in forces)


def _cross(kind: Kind, number: int, surface: Surface) -> Task:
    x, y = CROSSES_MM[number]
    place = (surface.width_mm / 2.0 + x, surface.height_mm / 2.0 + y)
    how = "and lift the finger" if kind == "touch" else "as short as you can"
    words = f"Touch cross {cross_name(number)} once, {how}."
    return Task(
        kind,
        Prompt("spot" if kind == "touch" else kind, words, at_mm=place),
        "target",
        {"target_mm": list(place)},
    )


def _height(height_mm: float, coins: bool) -> Task:
    words = (
        f"Lay the middle joint of the finger on the coins, {height_mm:g} mm high. The fingertip is "
        "stretched out beyond them and touches nothing. Hold still until the tone."
        if coins
        else f"Rest the fingertip on the peg of {height_mm:g} mm, so that it hides the peg. Hold "
        "still until the tone."
    )
    return Task(
        "hover", Prompt("level", words, height_mm=height_mm), "hover", {"height_mm": height_mm}
    )


def _force(force_g: float) -> Task:
    words = f"Press until the scale shows {force_g:.0f} grams. Hold it until the tone."
    return Task(
        "pressure", Prompt("level", words, force_g=force_g), "pressure", {"force_g": force_g}
    )
