"""Results as rows: one a person, task, method and figure, for whoever wants to reckon further."""

from __future__ import annotations

import csv
from collections.abc import Iterable, Iterator, Sequence
from typing import TextIO

import numpy as np

from halo_service.evaluation.metrics.confidence import Sureness, score_sureness
from halo_service.evaluation.metrics.difficult import STEPS, Awkward, by_value
from halo_service.evaluation.metrics.levels import Trial
from halo_service.evaluation.metrics.result import Result
from halo_service.evaluation.metrics.retaps import threshold_mm, told_by_lift
from halo_service.evaluation.metrics.scores import Scores
from halo_service.evaluation.metrics.spatial import as_the_paper, from_target, from_truth, spatial
from halo_service.evaluation.metrics.speeds import Speed, rank_correlation, relative_error
from halo_service.evaluation.metrics.timing import median_late

COLUMNS = (
    "seed", "subject", "material", "family", "task", "method", "figure", "value", "note",
    "profile", "settings", "version",
)  # fmt: skip
DIGITS = 4
"""Decimals: a tenth of a micrometre, far below what anything here measures."""

Figure = tuple[str, float | None]
"""Name with its unit, and value; None where the take gave no occasion."""


def write(results: Sequence[Result], version: str, out: TextIO) -> None:
    """Write all rows with a head. `version`: of the package that made them."""
    table = csv.writer(out, lineterminator="\n")
    table.writerow(COLUMNS)
    for each in results:
        who = each.subject
        head = ("" if who.seed is None else who.seed, who.name, who.material, who.family)
        tail = (each.profile, each.settings, version)
        for name, value, note in _rows(each):
            table.writerow((*head, each.task, each.method, name, value, note, *tail))


def figures(scores: Scores) -> Iterator[Figure]:
    """Yield every figure of one take, those without an occasion included."""
    yield from _touches(scores)
    yield from _sureness(scores.sureness)
    yield from _spatial(scores)
    yield from _timing(scores)
    yield from _speeds("strike", scores.strikes)
    yield from _speeds("velocity", scores.velocities)
    yield from _conduct(scores)
    yield from _levels(scores.trials)
    jumps = [jump.jump_mm for jump in scores.jumps]
    yield "hover_jump_p99_mm", _percentile(jumps, 99.0)
    yield "hover_jump_largest_mm", max(jumps, default=None)
    shares = told_by_lift(scores.retaps)
    yield "least_lift_mm", threshold_mm(shares)
    for lift, share in shares.items():
        yield f"retaps_told_share_{lift:g}_mm", share
    yield from _awkward(scores.awkward)
    yield from _typing(scores)


def _rows(result: Result) -> Iterator[tuple[str, str, str]]:
    """Yield figure, value and note of one result."""
    if result.scores is None:
        yield "calibrated", "0", result.refused
        return
    yield "calibrated", "1", ""
    for name, value in figures(result.scores):
        if value is not None and np.isfinite(value):
            yield name, f"{round(value, DIGITS):g}" if value % 1 else f"{value:.0f}", ""


def _touches(scores: Scores) -> Iterator[Figure]:
    touches = scores.touches
    yield "touches", touches.true
    yield "missed", len(touches.missed)
    yield "doubled", len(touches.doubled)
    yield "outside", len(touches.outside)
    yield "ghosts", len(touches.ghosts)
    yield "blind", len(touches.blind)
    yield "blind_told", touches.blind_hits
    if touches.true:
        yield "precision", touches.precision
        yield "recall", touches.recall
        yield "f1", touches.f1


def _sureness(sureness: Sureness) -> Iterator[Figure]:
    if sureness.told:
        yield "wrong_surely", sureness.wrong_surely
        yield "wrong_unsurely", sureness.wrong_unsurely
    if sureness.right:
        yield "right_surely_share", sureness.right_surely / sureness.right


def _awkward(pairs: Sequence[Awkward]) -> Iterator[Figure]:
    for (kind, value), touches in by_value(pairs).items():
        sureness, at = score_sureness(touches), f"at_{value:g}_{STEPS[kind].rpartition('_')[2]}"
        yield f"{kind}_told_share_{at}", touches.recall
        yield f"{kind}_wrong_surely_{at}", sureness.wrong_surely
        yield f"{kind}_wrong_unsurely_{at}", sureness.wrong_unsurely
        yield f"{kind}_off_mm_{at}", _mean(hit.off_mm for hit in touches.hits)


def _spatial(scores: Scores) -> Iterator[Figure]:
    off = spatial(from_truth(scores.touches.hits))
    if off is not None:
        yield "spatial_mean_mm", off.mean_mm
        yield "spatial_sd_mm", off.sd_mm
        yield "spatial_median_mm", off.median_mm
        yield "spatial_p95_mm", off.p95_mm
        yield "spatial_bias_x_mm", off.bias_mm[0]
        yield "spatial_bias_y_mm", off.bias_mm[1]
        yield "spatial_ellipse_long_mm", 2.0 * off.ellipse.major_mm
        yield "spatial_ellipse_short_mm", 2.0 * off.ellipse.minor_mm
    errors = from_target(scores.touches.hits)
    reduced = spatial(as_the_paper(errors))
    if reduced is not None:
        yield "spatial_as_the_paper_mm", reduced.mean_mm
        yield "spatial_common_offset_mm", float(np.hypot(*errors.mean(axis=0)))


def _timing(scores: Scores) -> Iterator[Figure]:
    timing = scores.timing
    late_ms, late_frames = median_late(timing) or (None, None)
    yield "down_frames_median", late_frames
    yield "down_ms_median", late_ms
    yield "down_ms_p95", _percentile([each.late_ms for each in timing], 95.0)
    yield "down_before_contact_share", _mean(each.early for each in timing)
    yield "down_ago_error_ms_median", _percentile([abs(t.down_ago_error_ms) for t in timing])
    yield "up_ms_median", _percentile([t.up_ms for t in timing if t.up_ms is not None])


def _speeds(what: str, speeds: Sequence[Speed]) -> Iterator[Figure]:
    yield f"{what}_error_share", relative_error(speeds)
    yield f"{what}_rank_correlation", rank_correlation(speeds)


def _conduct(scores: Scores) -> Iterator[Figure]:
    conduct = scores.conduct
    yield "stuck", conduct.stuck
    yield "id_changes", conduct.id_changes
    yield "misnamed", conduct.misnamed
    yield "strange_share", conduct.strange / conduct.pointers if conduct.pointers else None
    yield "unseen_share", conduct.unseen / conduct.fingers if conduct.fingers else None


def _levels(trials: Sequence[Trial]) -> Iterator[Figure]:
    for kind, unit, level_unit in (("hover", "mm", "mm"), ("pressure", "percent", "g")):
        mine = [trial for trial in trials if trial.kind == kind]
        yield f"{kind}_error_{unit}", _mean(trial.error for trial in mine)
        yield f"{kind}_bias_{unit}", _mean(trial.bias for trial in mine)
        yield f"{kind}_unseen_share", _mean(trial.unseen for trial in mine)
        for level in sorted({trial.level for trial in mine}):
            held, at = [t for t in mine if t.level == level], f"at_{level:g}_{level_unit}"
            yield f"{kind}_error_{unit}_{at}", _mean(trial.error for trial in held)
            yield f"{kind}_bias_{unit}_{at}", _mean(trial.bias for trial in held)


def _typing(scores: Scores) -> Iterator[Figure]:
    if scores.keys.struck:
        yield "keys_struck", scores.keys.struck
        yield "keys_wrong", scores.keys.wrong
        yield "keys_missed", scores.keys.missed
        yield "keys_doubled", scores.keys.doubled
    typed = [phrase.typed for phrase in scores.phrases]
    perfect = [phrase.perfect for phrase in scores.phrases]
    yield "wpm", _mean(each.wpm for each in typed)
    yield "awpm", _mean(each.awpm for each in typed)
    yield "perfect_awpm", _mean(each.awpm for each in perfect)
    yield "uncorrected_share", _mean(each.uncorrected_rate for each in typed)
    yield "perfect_uncorrected_share", _mean(each.uncorrected_rate for each in perfect)
    yield "corrected_share", _mean(each.corrected_rate for each in typed)


def _mean(values: Iterable[float]) -> float | None:
    known = [value for value in values if np.isfinite(value)]
    return float(np.mean(known)) if known else None


def _percentile(values: Sequence[float], percent: float = 50.0) -> float | None:
    return float(np.percentile(values, percent)) if values else None
