"""A line a person, task and method: what one looks at while changing the sensing."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from halo_service.evaluation.metrics.levels import Trial
from halo_service.evaluation.metrics.result import Result
from halo_service.evaluation.metrics.scores import Scores
from halo_service.evaluation.metrics.spatial import from_truth, spatial
from halo_service.evaluation.metrics.timing import median_late


def brief(results: Sequence[Result]) -> Iterator[str]:
    """Yield the lines."""
    for each in results:
        who = f"{each.subject.name:<12} {each.task:<15} {each.method:<7}"
        if each.scores is None:
            yield f"{who} cannot be calibrated: {each.refused}"
        else:
            for words in filter(None, (_touches(each.scores), _levels(each.scores))):
                yield f"{who} {words}"


def _touches(scores: Scores) -> str:
    touches = scores.touches
    if not touches.true:
        ghosts = len(touches.ghosts)
        return f"no touch, {ghosts} ghosts" if ghosts else ""
    words = (
        f"{touches.true} touches: {len(touches.missed)} missed, {len(touches.doubled)} doubled, "
        f"{len(touches.outside)} outside, {len(touches.ghosts)} ghosts, F1 {100 * touches.f1:.1f}"
    )
    off = spatial(from_truth(touches.hits))
    if off is not None:
        words += (
            f" | off {off.mean_mm:.1f} mm, median {off.median_mm:.1f}, bias "
            f"{off.bias_mm[0]:+.1f} {off.bias_mm[1]:+.1f}"
        )
    late = median_late(scores.timing)
    if late is not None:
        words += f" | {late[1]:g} frames, {late[0]:.0f} ms late"
    conduct = scores.conduct
    return words + (
        f" | {conduct.stuck} stuck, {conduct.id_changes} ids, "
        f"{conduct.strange} strange, {100 * conduct.unseen / max(conduct.fingers, 1):.1f} % unseen"
    )


def _levels(scores: Scores) -> str:
    if not scores.trials:
        return ""
    kind = scores.trials[0].kind
    unit = "mm" if kind == "hover" else "% of 385 g"
    levels = sorted({trial.level for trial in scores.trials})
    parts = [f"{level:g}: {_mean(scores.trials, level)}" for level in levels]
    unseen = 100.0 * float(np.mean([trial.unseen for trial in scores.trials]))
    return f"{kind} error {_mean(scores.trials)} {unit} ({', '.join(parts)}), {unseen:.1f} % unseen"


def _mean(trials: Sequence[Trial], level: float | None = None) -> str:
    errors = [t.error for t in trials if level in (None, t.level) and np.isfinite(t.error)]
    return f"{np.mean(errors):.2f}" if errors else "-"
