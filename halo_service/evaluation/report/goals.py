"""The paper's figures, what is aimed for, and what each method reaches: one line a goal.

Rule: whoever falls short of a goal is told so; what nobody measured is told too.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from halo_service.evaluation.metrics.result import Result
from halo_service.evaluation.report import select
from halo_service.evaluation.report.measures import (
    DOUBLED_OF,
    HOVER_MM,
    PRESSURE_SHARE,
    STUDIED,
    Measure,
    accuracy,
    all_fingers,
    awpm,
    contact_to_down,
    counts,
    least_lift,
    level,
    not_calibrated,
    palms,
    real_taps,
    right_surely,
    spatial_error,
    spatial_error_as_the_paper,
    strike_speed,
    stuck_and_renamed,
    velocity,
    without_pointer,
    worst_family,
    wrong_keys,
    wrong_surely,
)
from halo_service.evaluation.report.table import Table

PASS, SHORT = "pass", "falls short"
NOT_MEASURED = "not measured"


@dataclass(frozen=True, slots=True)
class Goal:
    """One line of the table."""

    figure: str
    paper: str
    goal: str
    measure: Measure
    """Of one method's results; None where they hold nothing of it."""


VIRTUAL = (
    "The paper's figures are of people and a real camera, the others of virtual people and a "
    "virtual camera: they compare methods, and are no promise about a table."
)
"""How to read the table of a study."""


def goal_table(results: Sequence[Result], note: str = VIRTUAL) -> Table:
    """Return the table, with a column a method. `note`: how to read it."""
    names = select.methods(results)
    by_method = {name: select.of(results, name) for name in names}
    return Table(
        "The paper's figures and ours",
        ("figure", "paper", "goal", *names),
        tuple(
            (each.figure, each.paper, each.goal, *(_cell(each, by_method[name]) for name in names))
            for each in GOALS
        ),
        note,
    )


def _cell(goal: Goal, results: Sequence[Result]) -> str:
    measured = goal.measure(results)
    if measured is None:
        return NOT_MEASURED
    if measured.meets is None:
        return measured.told
    return f"{measured.told}, {PASS if measured.meets else SHORT}"


GOALS = (
    Goal("tables that could not be calibrated", "not told", "0", not_calibrated),
    Goal("touch: precision / recall / F1", "98.8 / 99.7 / 99.2 %", "F1 ≥ 99.9 %", accuracy),
    Goal(
        "missed / doubled / outside and ghosts",
        "13 / 45 / 31 of 3840",
        f"0 / ≤ {DOUBLED_OF} of {STUDIED} / 0",
        counts,
    ),
    Goal("real people's taps that hold a frame: F1", "not told", "≥ 98 %", real_taps),
    Goal("spatial error of hits, nothing else removed", "not told", "≤ 3 mm", spatial_error),
    Goal(
        "spatial error from the target, common offset removed",
        "5.5 mm, after 7 mm",
        "none",
        spatial_error_as_the_paper,
    ),
    Goal(
        "touch point threshold: least lift at which 99 % are told",
        "4.97 mm (mean travel)",
        "≤ 2 mm",
        least_lift,
    ),
    Goal("hover error", "2.81 ± 0.99 mm", "≤ 1 mm", level("hover", False, "mm", HOVER_MM)),
    Goal(
        "hover error at doubled noise", "not told", "≤ 1 mm", level("hover", True, "mm", HOVER_MM)
    ),
    Goal(
        "hover error, worst family of curves",
        "not told",
        "≤ 1 mm",
        worst_family("hover", "mm", HOVER_MM),
    ),
    Goal(
        "pressure error, of 385 g",
        "18.77 ± 11.11 %",
        "≤ 8 %",
        level("pressure", False, "%", PRESSURE_SHARE),
    ),
    Goal(
        "pressure error at doubled noise",
        "not told",
        "≤ 8 %",
        level("pressure", True, "%", PRESSURE_SHARE),
    ),
    Goal(
        "pressure error, worst family of curves",
        "not told",
        "≤ 8 %",
        worst_family("pressure", "%", PRESSURE_SHARE),
    ),
    Goal(
        "keys landed ≥ 2 mm inside: wrong / missed / doubled", "not told", "≤ 1 % each", wrong_keys
    ),
    Goal("typing: AWPM, of what a perfect sensor gives", "26.3", "none", awpm),
    Goal("contact → down, median", "not told", "≤ 1 frame (33 ms)", contact_to_down),
    Goal("strike speed: off by / rank correlation", "not told", "none", strike_speed),
    Goal("pointer velocity: off by / rank correlation", "not told", "none", velocity),
    Goal("touches told of palms and curled fingers", "not told", "0", palms),
    Goal(
        "hard to see: told wrongly, surely / unsurely, of all told",
        "not told",
        "0 surely",
        wrong_surely,
    ),
    Goal("right touches told surely: pointing / hard to see", "not told", "none", right_surely),
    Goal("every finger of two hands: F1", "one finger", "none", all_fingers),
    Goal("touches that stick / ids that change", "not told", "0 / 0", stuck_and_renamed),
    Goal("low fingers that play, without a pointer", "not told", "none", without_pointer),
)
