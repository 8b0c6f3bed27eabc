"""The paper's figures, the goals, and what each method reaches: one line per goal.

Rule: the goals are here, once; a goal that is missed or not measured says so.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

from halo_service.evaluation.metrics.result import Result
from halo_service.evaluation.metrics.scores import Scores
from halo_service.evaluation.report import select
from halo_service.evaluation.report.figures import NONE, Value, Values, ValuesOf, cell
from halo_service.evaluation.report.select import Choice
from halo_service.evaluation.report.table import Table
from halo_service.geometry.k4a import DEPTH_FPS

PASS, FAIL = "pass", "fail"
NOT_MEASURED = "not measured"
FRAME_MS = 1000.0 / DEPTH_FPS["NFOV_UNBINNED"]
"""Of the narrow unbinned mode, whatever the mode of a user."""
NO_READING = 0.01
"""Chosen: a method without a reading in more of the frames has not measured the level."""
Limits = Mapping[str, float]


@dataclass(frozen=True, slots=True)
class Goal:
    """One line of the table."""

    figure: str
    paper: str
    """The paper's figure."""
    goal: str
    """In words; the limits below in numbers."""
    shown: str
    """Template of figures, as in `figures.cell`."""
    of: Choice = select.everything
    at_most: Limits = field(default_factory=dict)
    at_least: Limits = field(default_factory=dict)
    worst_by: Callable[[Result], str] | None = None
    """Groups of results: each figure is that of its worst group, the one with the largest value."""
    applies: Callable[[Scores], bool] = field(default=lambda scores: True)
    needs_truth: bool = False
    """Without the truth, the figure is from the target and meets or misses no goal."""


VIRTUAL = (
    "The paper's figures are of people and a real camera, the others of virtual people and a "
    "virtual camera: they compare methods and say nothing about a real table."
)
"""How to read the table of a study."""


def goal_table(results: Sequence[Result], note: str = VIRTUAL) -> Table:
    """Return the table, with one column per method. `note`: how to read it."""
    names = select.methods(results)
    by_method = {name: select.of(results, name) for name in names}
    rows = (
        (each.figure, each.paper, each.goal, *(_cell(each, by_method[name]) for name in names))
        for each in GOALS
    )
    return Table(
        "The paper's figures and ours", ("figure", "paper", "goal", *names), tuple(rows), note
    )


def _cell(goal: Goal, results: Sequence[Result]) -> str:
    if goal is CALIBRATED:
        return _calibrated(results)
    chosen = select.scored(results, goal.of)
    scores = select.pooled(chosen)
    if not chosen or not goal.applies(scores):
        return NOT_MEASURED
    values: Values = ValuesOf(scores)
    if goal.worst_by is not None:
        values = Worst(chosen, goal.worst_by)
    text = cell(goal.shown, values)
    if text == NONE:
        return NOT_MEASURED
    if goal.needs_truth and any(result.by_script for result in chosen):
        return f"{text} from the target"
    return f"{text}, {_verdict(goal, values)}" if goal.at_most or goal.at_least else text


def _verdict(goal: Goal, values: Values) -> str:
    low = all(values[name] <= limit for name, limit in goal.at_most.items())
    high = all(values[name] >= limit for name, limit in goal.at_least.items())
    return PASS if low and high else FAIL


def _calibrated(results: Sequence[Result]) -> str:
    people = {result.subject.name for result in results}
    refused = {result.subject.name for result in results if result.refused}
    if not people:
        return NOT_MEASURED
    return f"{len(refused)} of {len(people)}, {FAIL if refused else PASS}"


class Worst:
    """Each figure of its worst group."""

    def __init__(self, results: Sequence[Result], group: Callable[[Result], str]) -> None:
        names = sorted({group(result) for result in results if group(result)})
        self._groups = {
            name: ValuesOf(select.pooled([r for r in results if group(r) == name]))
            for name in names
        }

    def __getitem__(self, name: str) -> Value:
        values = {group: each[name] for group, each in self._groups.items()}
        known = {group: value for group, value in values.items() if not math.isnan(value)}
        if not known:
            return Value(math.nan)
        worst = max(known, key=known.__getitem__)
        known[worst].group = worst
        return known[worst]


def _family_and_noise(result: Result) -> str:
    noise = ", doubled noise" if select.doubled_noise(result) else ""
    return f"{result.subject.family}{noise}" if result.subject.family else ""


def _reports_hover(scores: Scores) -> bool:
    """Whether the method reports more than touches."""
    return not scores.behaviour.pointers or bool(scores.behaviour.hovering)


def _level(kind: str, of: Choice, title: str, paper: str) -> Goal:
    unit, short, most = {"hover": ("mm", "mm", 1.0), "pressure": ("percent", "%", 8.0)}[kind]
    error, silent = f"{kind}_error_{unit}", f"{kind}_no_reading_share"
    shown = (
        f"{{{error}:.2f}} ± {{{kind}_error_sd_{unit}:.2f}} {short}, "
        f"{{{silent}:.0%}} % without reading"
    )
    limits = {error: most, silent: NO_READING}
    return Goal(title, paper, f"≤ {most:g} {short}", shown, of, limits)


def _worst_family(kind: str) -> Goal:
    plain = _level(kind, select.everything, f"{kind} error, worst family of curves", "-")
    error, silent = plain.at_most
    unit = plain.goal.rpartition(" ")[2]
    shown = (
        f"{{{error}:.2f}} {unit} ({{{error}.group}}), "
        f"{{{silent}:.0%}} % without reading ({{{silent}.group}})"
    )
    return Goal(
        plain.figure, "-", plain.goal, shown, at_most=plain.at_most, worst_by=_family_and_noise
    )


CALIBRATED = Goal("tables that could not be calibrated", "-", "0", "")
GOALS = (
    CALIBRATED,
    Goal("touch: precision / recall / F1", "98.8 / 99.7 / 99.2 %", "F1 ≥ 99.9 %",
         "{precision:.2%} / {recall:.2%} / {f1:.2%} %", select.pointing, at_least={"f1": 0.999}),
    Goal("missed / doubled / outside and ghosts", "13 / 45 / 31 of 3840", "0 / ≤ 2 of 3840 / 0",
         "{missed} / {doubled} / {outside_and_ghosts} of {touches}", select.pointing,
         {"missed": 0, "doubled_share": 2 / 3840, "outside_and_ghosts": 0},
         applies=lambda scores: scores.touches.true > 0),
    Goal("real people's taps that at least one frame shows: F1", "-", "≥ 98 %",
         "{f1:.2%} % of {touches} ({between_frames_reported} of {between_frames} between frames)",
         select.labelled, at_least={"f1": 0.98}),
    Goal("spatial error of hits, nothing else removed", "-", "≤ 3 mm",
         "{spatial_mean_mm:.1f} ± {spatial_sd_mm:.1f} mm", select.pointing,
         {"spatial_mean_mm": 3.0}, needs_truth=True),
    Goal("spatial error from the target, common offset removed", "5.5 mm, after 7 mm", "-",
         "{spatial_paper_method_mm:.1f} mm, after {spatial_common_offset_mm:.1f} mm",
         select.pointing),
    Goal("touch point threshold: least lift from which on 99 % are reported",
         "4.97 mm (mean travel)", "≤ 2 mm", "{least_lift_mm:g} mm (of ≤ {largest_lift_mm:g} mm)",
         select.threshold, {"least_lift_mm": 2.0}),
    _level("hover", select.plain_noise, "hover error", "2.81 ± 0.99 mm"),
    _level("hover", select.doubled_noise, "hover error at doubled noise", "-"),
    _worst_family("hover"),
    _level("pressure", select.plain_noise, "pressure error, of 385 g", "18.77 ± 11.11 %"),
    _level("pressure", select.doubled_noise, "pressure error at doubled noise", "-"),
    _worst_family("pressure"),
    Goal("keys landed ≥ 2 mm inside: wrong / missed / doubled", "-", "≤ 1 % each",
         "{keys_wrong_share:.1%} / {keys_missed_share:.1%} / {keys_doubled_share:.1%} % "
         "of {keys_struck}", select.typing,
         {"keys_wrong_share": 0.01, "keys_missed_share": 0.01, "keys_doubled_share": 0.01}),
    Goal("typing: AWPM, of what a perfect sensor gives", "26.3", "-",
         "{awpm:.1f} of {perfect_awpm:.1f}", select.balanced_typing),
    Goal("contact → down, median", "-", "≤ 1 frame (33 ms)",
         "{down_ms_median:.0f} ms (p95 {down_ms_p95:.0f}), {down_frames_median:+g} frames, "
         "{down_before_contact_share:.0%} % before contact", select.pointing,
         {"down_ms_median": FRAME_MS}),
    Goal("strike speed: error / rank correlation", "-", "-",
         "{strike_error_share:.0%} % / {strike_rank_correlation:.2f}", select.pointing),
    Goal("pointer velocity: error / rank correlation", "-", "-",
         "{velocity_error_share:.0%} % / {velocity_rank_correlation:.2f}", select.pointing),
    Goal("false touches by palms and curled fingers", "-", "0",
         "{outside_and_ghosts} with {touches} touches", select.two_hands,
         {"outside_and_ghosts": 0}),
    Goal("difficult to see: wrong with high / low confidence, of all reported", "-", "0 high",
         "{wrong_high_confidence} / {wrong_low_confidence} of {reported}, "
         "{missed} of {touches} missed", select.difficult, {"wrong_high_confidence": 0}),
    Goal("right touches with high confidence: pointing", "-", "-",
         "{right_high_confidence_share:.1%} %", select.pointing),
    Goal("right touches with high confidence: difficult to see", "-", "-",
         "{right_high_confidence_share:.1%} %", select.difficult),
    Goal("every finger of two hands: F1", "one finger", "-", "{f1:.1%} % of {touches}",
         select.ten_fingers),
    Goal("stuck touches / changed ids", "-", "0 / 0", "{stuck} / {id_changes}",
         at_most={"stuck": 0, "id_changes": 0}),
    Goal("active low fingers without a pointer", "-", "-", "{without_pointer_share:.1%} %",
         applies=_reports_hover),
)  # fmt: skip
