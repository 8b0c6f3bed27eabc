"""The one table of figures: name with unit, meaning, and how it is computed from scores.

The goals, the breakdowns, the short lines, the CSV file and `docs/results/figures.md` all read this
table, so a figure is defined once. A figure is nan where the scores give no occasion for it.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from string import Formatter
from typing import Protocol

import numpy as np

from halo_service.evaluation.metrics.confidence import score_confidence
from halo_service.evaluation.metrics.difficult import STEPS
from halo_service.evaluation.metrics.levels import Trial
from halo_service.evaluation.metrics.pool import pool
from halo_service.evaluation.metrics.retaps import threshold_mm
from halo_service.evaluation.metrics.scores import Scores
from halo_service.evaluation.metrics.spatial import (
    Spatial,
    as_the_paper,
    from_target,
    from_truth,
    spatial,
)
from halo_service.evaluation.metrics.speeds import rank_correlation, relative_error
from halo_service.evaluation.metrics.touches import Touches

NONE = "-"
"""Shown where nothing was measured."""
Compute = Callable[[Scores], float]


@dataclass(frozen=True, slots=True)
class Figure:
    """One number of the report."""

    name: str
    """Ends with its unit: `_mm`, `_ms`, `_percent`, `_share` (0 to 1); else a count."""
    meaning: str
    of: Compute


def _ratio(part: float, whole: float) -> float:
    return part / whole if whole else math.nan


def _mean(values: Iterable[float]) -> float:
    known = [value for value in values if np.isfinite(value)]
    return float(np.mean(known)) if known else math.nan


def _sd(values: Iterable[float]) -> float:
    known = [value for value in values if np.isfinite(value)]
    return float(np.std(known)) if known else math.nan


def _percentile(values: Iterable[float], percent: float = 50.0) -> float:
    known = list(values)
    return float(np.percentile(known, percent)) if known else math.nan


def _place(read: Callable[[Spatial], float]) -> Compute:
    def of(scores: Scores) -> float:
        off = spatial(from_truth(scores.touches.hits))
        return math.nan if off is None else read(off)

    return of


def _as_the_paper_mm(scores: Scores) -> float:
    off = spatial(as_the_paper(from_target(scores.touches.hits)))
    return math.nan if off is None else off.mean_mm


def _common_offset_mm(scores: Scores) -> float:
    errors = from_target(scores.touches.hits)
    return float(np.hypot(*errors.mean(axis=0))) if len(errors) else math.nan


def _of_reported(scores: Scores, count: int) -> float:
    """A count of wrong touches; none where no touch was reported."""
    return count if scores.confidence.reported else math.nan


def _of_keys(scores: Scores, count: int) -> float:
    return count if scores.keys.struck else math.nan


def _level(kind: str, unit: str) -> tuple[Figure, ...]:
    """Return the figures of held heights or forces."""

    def trials(scores: Scores) -> list[Trial]:
        return [trial for trial in scores.trials if trial.kind == kind]

    return (
        Figure(f"{kind}_error_{unit}", f"mean absolute error of held {kind}",
               lambda s: _mean(t.error for t in trials(s))),
        Figure(f"{kind}_error_sd_{unit}", "its standard deviation over the trials",
               lambda s: _sd(t.error for t in trials(s))),
        Figure(f"{kind}_bias_{unit}", f"mean error of held {kind}, reported minus true",
               lambda s: _mean(t.bias for t in trials(s))),
        Figure(f"{kind}_no_reading_share", "frames of these trials without a reading",
               lambda s: _mean(t.no_reading for t in trials(s))),
    )  # fmt: skip


FIGURES = (
    Figure("touches", "true touches that at least one frame shows", lambda s: s.touches.true),
    Figure("missed", "touches without a down", lambda s: len(s.touches.missed)),
    Figure("doubled", "further downs during a touch", lambda s: len(s.touches.doubled)),
    Figure("outside", "downs during a touch, more than 25 mm from the target",
           lambda s: len(s.touches.outside)),
    Figure("ghosts", "downs while nothing touches", lambda s: len(s.touches.ghosts)),
    Figure("outside_and_ghosts", "both together",
           lambda s: len(s.touches.outside) + len(s.touches.ghosts)),
    Figure("doubled_share", "doubled downs of all touches",
           lambda s: _ratio(len(s.touches.doubled), s.touches.true)),
    Figure("between_frames", "touches that no frame shows",
           lambda s: len(s.touches.between_frames)),
    Figure("between_frames_reported", "how many of those were reported",
           lambda s: s.touches.between_frames_hits),
    Figure("precision", "hits of all published downs",
           lambda s: s.touches.precision if s.touches.true else math.nan),
    Figure("recall", "hits of all touches",
           lambda s: s.touches.recall if s.touches.true else math.nan),
    Figure("f1", "harmonic mean of precision and recall",
           lambda s: s.touches.f1 if s.touches.true else math.nan),
    Figure("reported", "published downs", lambda s: s.confidence.reported),
    Figure("wrong_high_confidence",
           "downs with confidence ≥ 0.75 that are doubled, outside, ghosts, or hits > 8 mm off",
           lambda s: _of_reported(s, s.confidence.wrong_high)),
    Figure("wrong_low_confidence", "the same with confidence < 0.75",
           lambda s: _of_reported(s, s.confidence.wrong_low)),
    Figure("right_high_confidence_share", "right downs that have confidence ≥ 0.75",
           lambda s: _ratio(s.confidence.right_high, s.confidence.right)),
    Figure("spatial_mean_mm", "mean distance of hits from the pad's true place",
           _place(lambda p: p.mean_mm)),
    Figure("spatial_sd_mm", "its standard deviation", _place(lambda p: p.sd_mm)),
    Figure("spatial_median_mm", "its median", _place(lambda p: p.median_mm)),
    Figure("spatial_p95_mm", "its 95th percentile", _place(lambda p: p.p95_mm)),
    Figure("spatial_bias_x_mm", "mean offset to the right", _place(lambda p: p.bias_mm[0])),
    Figure("spatial_bias_y_mm", "mean offset towards the user", _place(lambda p: p.bias_mm[1])),
    Figure("spatial_ellipse_long_mm", "long axis of the ellipse that holds 95 %",
           _place(lambda p: 2.0 * p.ellipse.major_mm)),
    Figure("spatial_ellipse_short_mm", "short axis of it",
           _place(lambda p: 2.0 * p.ellipse.minor_mm)),
    Figure("spatial_paper_method_mm",
           "mean distance from the target without common offset and outliers, as in the paper",
           _as_the_paper_mm),
    Figure("spatial_common_offset_mm", "the common offset from the targets", _common_offset_mm),
    Figure("down_frames_median", "frames from the first in contact to the report, median",
           lambda s: _percentile(t.late_frames for t in s.timing)),
    Figure("down_ms_median", "from contact to the frame that reports it; early counts as 0 ms",
           lambda s: _percentile(t.late_ms for t in s.timing)),
    Figure("down_ms_p95", "its 95th percentile",
           lambda s: _percentile((t.late_ms for t in s.timing), 95.0)),
    Figure("down_before_contact_share", "downs that are reported before their contact",
           lambda s: _mean(t.early for t in s.timing)),
    Figure("down_ago_error_ms_median", "how wrong `ago_ms` dates the contact",
           lambda s: _percentile(abs(t.down_ago_error_ms) for t in s.timing)),
    Figure("up_ms_median", "from the contact's end to the frame that reports it",
           lambda s: _percentile(t.up_ms for t in s.timing if t.up_ms is not None)),
    Figure("strike_error_share", "median error of the strike speed",
           lambda s: relative_error(s.strikes)),
    Figure("strike_rank_correlation", "Spearman's, reported and true strike speed",
           lambda s: rank_correlation(s.strikes)),
    Figure("velocity_error_share", "median error of a moving pointer's velocity",
           lambda s: relative_error(s.velocities)),
    Figure("velocity_rank_correlation", "Spearman's, reported and true speed",
           lambda s: rank_correlation(s.velocities)),
    Figure("stuck", "touches reported for 0.25 s longer than they last",
           lambda s: s.behaviour.stuck),
    Figure("id_changes", "new ids of fingers that stay", lambda s: s.behaviour.id_changes),
    Figure("wrong_finger", "hits reported as another finger or hand",
           lambda s: s.behaviour.wrong_finger),
    Figure("stray_share", "pointers more than 60 mm from any finger",
           lambda s: _ratio(s.behaviour.stray, s.behaviour.pointers)),
    Figure("without_pointer_share", "active fingers below 80 mm that have no pointer",
           lambda s: _ratio(s.behaviour.without_pointer, s.behaviour.fingers)),
    *_level("hover", "mm"),
    *_level("pressure", "percent"),
    Figure("hover_jump_p99_mm", "change of hover between frames beyond the finger's, p99",
           lambda s: _percentile((jump.jump_mm for jump in s.jumps), 99.0)),
    Figure("hover_jump_largest_mm", "the largest",
           lambda s: max((jump.jump_mm for jump in s.jumps), default=math.nan)),
    Figure("retaps_reported_share", "re-taps that are reported",
           lambda s: _mean(retap.reported for retap in s.retaps)),
    Figure("largest_lift_mm", "largest lift between two taps",
           lambda s: max((retap.lift_mm for retap in s.retaps), default=math.nan)),
    Figure("least_lift_mm", "least lift from which on 99 % of re-taps are reported",
           lambda s: threshold_mm(s.retaps)),
    Figure("keys_struck", "keystrokes that land at least 2 mm inside a key",
           lambda s: _of_keys(s, s.keys.struck)),
    Figure("keys_wrong", "of these: reported as another key or none",
           lambda s: _of_keys(s, s.keys.wrong)),
    Figure("keys_missed", "of these: not reported", lambda s: _of_keys(s, s.keys.missed)),
    Figure("keys_doubled", "further characters that these would type",
           lambda s: _of_keys(s, s.keys.doubled)),
    Figure("keys_wrong_share", "share of wrong keys",
           lambda s: _ratio(s.keys.wrong, s.keys.struck)),
    Figure("keys_missed_share", "share of missed keys",
           lambda s: _ratio(s.keys.missed, s.keys.struck)),
    Figure("keys_doubled_share", "share of doubled keys",
           lambda s: _ratio(s.keys.doubled, s.keys.struck)),
    Figure("wpm", "words per minute", lambda s: _mean(p.typed.wpm for p in s.phrases)),
    Figure("awpm", "words per minute times accuracy",
           lambda s: _mean(p.typed.awpm for p in s.phrases)),
    Figure("perfect_awpm", "the same for a perfect sensor",
           lambda s: _mean(p.perfect.awpm for p in s.phrases)),
    Figure("uncorrected_share", "characters left wrong in the text",
           lambda s: _mean(p.typed.uncorrected_rate for p in s.phrases)),
    Figure("perfect_uncorrected_share", "the same for a perfect sensor",
           lambda s: _mean(p.perfect.uncorrected_rate for p in s.phrases)),
    Figure("corrected_share", "characters erased",
           lambda s: _mean(p.typed.corrected_rate for p in s.phrases)),
)  # fmt: skip
"""In the order of the CSV file."""
BY_NAME = {figure.name: figure for figure in FIGURES}


class Value(float):
    """A figure that formats itself: `%` is percent without the sign, nan is `-`, inf is `∞`."""

    group = ""
    """The group with this value, where it is the worst of several."""

    def __format__(self, spec: str) -> str:
        """Format like a float; without a format like a count."""
        if not math.isfinite(self):
            return NONE if math.isnan(self) else "∞"
        if spec.endswith("%"):
            return format(100.0 * self, f"{spec[:-1]}f")
        return format(float(self), spec or ".0f")


class Values(Protocol):
    """Figures by name."""

    def __getitem__(self, name: str, /) -> Value:
        """Return one figure."""


class ValuesOf:
    """The figures of some scores, computed when they are read."""

    def __init__(self, scores: Scores) -> None:
        self._scores = scores

    def __getitem__(self, name: str) -> Value:
        return Value(BY_NAME[name].of(self._scores))


def cell(shown: str, values: Values) -> str:
    """Fill in a template such as "{f1:.2%} %"; NONE where its first figure was not measured."""
    first = next(name for _, name, _, _ in Formatter().parse(shown) if name)
    return NONE if math.isnan(values[first]) else shown.format_map(values)


def figures(scores: Scores) -> Iterator[tuple[str, float]]:
    """Yield every figure of some scores, then those of each level, lift and difficulty."""
    for figure in FIGURES:
        yield figure.name, figure.of(scores)
    for (kind, level), part in by_level(scores).items():
        unit = "mm" if kind == "hover" else "g"
        yield from _parts(part, f"{{}}_at_{level:g}_{unit}", *LEVEL_FIGURES[kind])
    for lift, part in by_lift(scores).items():
        yield from _parts(part, f"{{}}_{lift:g}_mm", "retaps_reported_share")
    for (kind, value), part in by_difficulty(scores).items():
        unit = STEPS[kind].rpartition("_")[2]
        yield from _parts(part, f"{kind}_{{}}_at_{value:g}_{unit}", *DIFFICULT_FIGURES)


LEVEL_FIGURES = {
    "hover": ("hover_error_mm", "hover_bias_mm"),
    "pressure": ("pressure_error_percent", "pressure_bias_percent"),
}
DIFFICULT_FIGURES = ("recall", "wrong_high_confidence", "wrong_low_confidence", "spatial_mean_mm")


def by_level(scores: Scores) -> Mapping[tuple[str, float], Scores]:
    """Split into kind and level, in order."""
    keys = sorted({(trial.kind, trial.level) for trial in scores.trials})
    return {
        key: Scores(trials=tuple(t for t in scores.trials if (t.kind, t.level) == key))
        for key in keys
    }


def by_lift(scores: Scores) -> Mapping[float, Scores]:
    """Split into lifts, in order."""
    lifts = sorted({retap.lift_mm for retap in scores.retaps})
    return {
        lift: Scores(retaps=tuple(r for r in scores.retaps if r.lift_mm == lift)) for lift in lifts
    }


def by_difficulty(scores: Scores) -> Mapping[tuple[str, float], Scores]:
    """Split into kind and value of difficult touches, in order."""
    parts = {}
    for key in sorted({(each.kind, each.value) for each in scores.difficult}):
        same = [each.touches for each in scores.difficult if (each.kind, each.value) == key]
        touches = pool(Touches, same)
        parts[key] = Scores(touches=touches, confidence=score_confidence(touches))
    return parts


def _parts(part: Scores, name: str, *names: str) -> Iterator[tuple[str, float]]:
    for each in names:
        yield name.format(each), BY_NAME[each].of(part)


def figures_page() -> str:
    """Return the Markdown page that explains every figure."""
    rows = (f"| `{figure.name}` | {figure.meaning} |" for figure in FIGURES)
    head = ("# Figures", "", "The figures of `halo evaluate --csv`, in their order.", "")
    return "\n".join([*head, "| figure | meaning |", "|---|---|", *rows, ""])
