"""The script of a recording: which step happens when. `Script` says what is allowed.

`[{"step": "background", "from_s": 0, "to_s": 2}, {"step": "hover", ..., "height_mm": 10}, ...]`;
times are seconds from the first depth frame, and what lies between the steps belongs to none.
"""

from __future__ import annotations

import json
import math
from dataclasses import dataclass, field
from itertools import pairwise
from pathlib import Path
from typing import Any

from halo_calibration.boards.board import FAMILIES
from halo_calibration.solvers.touch import HARD, HELD_STATES, STATES, StateValues
from halo_service.errors import UserError
from halo_service.files import read_text

NEEDED = ("step", "from_s", "to_s")
FIELDS: dict[str, tuple[str, ...]] = {
    "background": (),
    "surface": ("by", "width_mm", "height_mm"),
    "projector": ("by", "width_px", "height_px"),
    "anchor": ("family", "marker", "size_mm"),
    "hover": ("height_mm",),
    "subtle": ("height_mm",),
    "touch": ("force_g",),
    "pressure": ("force_g",),
    "hard": ("force_g",),
    "sweep": ("force_g",),
}
"""The steps a script may name, and its fields in addition to the times."""
WORDS: dict[tuple[str, str], tuple[str, ...]] = {
    ("surface", "by"): ("view", "markers", "touch"),
    ("projector", "by"): ("markers", "gray", "touch"),
    ("anchor", "family"): tuple(FAMILIES),
}
"""Fields that are words, and which; all others are numbers."""


@dataclass(frozen=True, slots=True)
class ScriptStep:
    """One step of a script."""

    step: str
    from_s: float
    to_s: float
    fields: dict[str, float]
    """Numbers of those in `FIELDS`."""
    words: dict[str, str] = field(default_factory=dict)
    """And those that are words."""


def read_script(path: Path) -> tuple[ScriptStep, ...]:
    """Read a script, earliest step first. Raises `UserError` for anything that is none."""
    try:
        data = json.loads(read_text(path))
    except (OSError, ValueError) as error:
        raise UserError(f"the script {path} cannot be read ({error}); correct --script") from error
    return parse_script(data, str(path))


def parse_script(data: Any, name: str) -> tuple[ScriptStep, ...]:
    """Check a script's content; `name` appears in the errors."""
    if not isinstance(data, list) or not data:
        raise UserError(f'the script {name} must be a list of steps: [{{"step": ...}}, ...]')
    lines = sorted((_line(each, name) for each in data), key=lambda line: line.from_s)
    for before, after in pairwise(lines):
        if after.from_s < before.to_s:
            raise UserError(
                f"the script {name} lets '{before.step}' and '{after.step}' overlap in time; "
                f"correct their from_s and to_s"
            )
        if after.step in {line.step for line in lines if line is not after}:
            raise UserError(f"the script {name} names '{after.step}' twice; leave one out")
    named = {line.step for line in lines}
    if named & set(HELD_STATES) and not named >= set(STATES):
        missing = ", ".join(state for state in STATES if state not in named)
        raise UserError(f"the script {name} lacks {missing}: the four states belong together")
    hard = next((line for line in lines if line.step == HARD), None)
    if hard is not None and "force_g" not in hard.fields:
        raise UserError(f"the script {name}: 'hard' needs force_g, the grams of the hard press")
    return tuple(lines)


def state_values_in(lines: tuple[ScriptStep, ...], otherwise: StateValues) -> StateValues:
    """Return the heights and forces that a script states, else those given otherwise."""
    said = {line.step: line.fields for line in lines}

    def of(step: str, field: str, other: float | None) -> float | None:
        return said.get(step, {}).get(field, other)

    return StateValues(
        of("hover", "height_mm", otherwise.hover_mm),
        of("subtle", "height_mm", otherwise.subtle_mm),
        of("touch", "force_g", otherwise.touch_g),
        of("pressure", "force_g", otherwise.pressure_g),
        of(HARD, "force_g", None),  # held if the script has it
    )


def _line(data: Any, name: str) -> ScriptStep:
    if not isinstance(data, dict) or not all(key in data for key in NEEDED):
        raise UserError(f"the script {name}: each step needs {', '.join(NEEDED)}; got {data!r}")
    step = data["step"]
    if step not in FIELDS:
        raise UserError(
            f"the script {name} names the step {step!r}, which cannot be calibrated; "
            f"known: {', '.join(FIELDS)}"
        )
    for key in data:
        if key not in NEEDED and key not in FIELDS[step]:
            known = ", ".join((*NEEDED, *FIELDS[step]))
            raise UserError(f"the script {name}: '{step}' has no field '{key}'; known: {known}")
    words = {key: _word(data[key], key, step, name) for key in data if (step, key) in WORDS}
    others = [key for key in data if key != "step" and key not in words]
    numbers = {key: _number(data[key], key, step, name) for key in others}
    from_s, to_s = numbers.pop("from_s"), numbers.pop("to_s")
    if step == "projector" and not {"width_px", "height_px"} <= numbers.keys():
        raise UserError(
            f"the script {name}: 'projector' needs width_px and height_px, the size of its picture"
        )
    if not 0.0 <= from_s < to_s:
        raise UserError(f"the script {name}: '{step}' must end after it begins, from 0 s on")
    return ScriptStep(step, from_s, to_s, numbers, words)


def _word(value: Any, key: str, step: str, name: str) -> str:
    known = WORDS[step, key]
    if value not in known:
        raise UserError(
            f"the script {name}: {key} of '{step}' must be one of {', '.join(known)}, not {value!r}"
        )
    return str(value)


def _number(value: Any, key: str, step: str, name: str) -> float:
    if type(value) not in (int, float) or not math.isfinite(value) or value < 0.0:
        raise UserError(f"the script {name}: {key} of '{step}' must be a number, not {value!r}")
    return float(value)
