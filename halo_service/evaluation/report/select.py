"""Which results a figure is made of.

Rule: a recording counts for every figure that it holds anything for; what is played under harder
conditions than the paper's counts for its own figure alone.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from halo_service.evaluation.metrics.levels import Trial
from halo_service.evaluation.metrics.result import Result
from halo_service.evaluation.metrics.scores import Scores
from halo_service.evaluation.metrics.touches import Touches, pooled

RECORDING = "recording"
"""The task of what nobody here has drawn."""
NOISE = "noise2"
"""In the names of tasks played at doubled noise."""
TYPING = ("typing-accurate", "typing", "typing-fast")
"""The paper's T1 to T3."""
HANDS = ("ten-fingers", "chaos")
"""Tasks of more than a pointing finger."""
HARD = ("awkward", "chaos")
"""Tasks whose touches are hard to see."""
LABELS = "labels"
"""Begins the names of tasks tapped when somebody really touched a tablet."""


def methods(results: Sequence[Result]) -> tuple[str, ...]:
    """Return the methods in the order in which they come."""
    return tuple(dict.fromkeys(result.method for result in results))


def of(results: Sequence[Result], method: str) -> list[Result]:
    """Return one method's."""
    return [result for result in results if result.method == method]


def pointing(results: Sequence[Result]) -> list[Scores]:
    """Return the scores of target pointing, of however many touches."""
    return [r.scores for r in results if r.scores and _base(r.task) in ("pointing", RECORDING)]


def tasks(results: Sequence[Result], *names: str) -> list[Scores]:
    """Return the scores of the named tasks."""
    return [r.scores for r in results if r.scores and _base(r.task) in names]


def hard(results: Sequence[Result]) -> list[Scores]:
    """Return the scores of touches that are hard to see."""
    return [r.scores for r in results if r.scores and (r.task in HARD or r.scores.awkward)]


def labelled(results: Sequence[Result]) -> list[Scores]:
    """Return the scores of real people's tap timing."""
    return [r.scores for r in results if r.scores and r.task.startswith(LABELS)]


def trials(results: Sequence[Result], kind: str, noisy: bool) -> list[Trial]:
    """Return the held levels, at plain or at doubled noise."""
    chosen = (r.scores for r in results if r.scores and (NOISE in r.task) is noisy)
    return [trial for scores in chosen for trial in scores.trials if trial.kind == kind]


def touches(parts: Sequence[Scores]) -> Touches:
    """Put their touches together."""
    return pooled([part.touches for part in parts])


def mean_error(held: Sequence[Trial]) -> tuple[float, float]:
    """Return the mean of the trials' errors and their standard deviation; nan without any."""
    errors = [trial.error for trial in held if not np.isnan(trial.error)]
    return (float(np.mean(errors)), float(np.std(errors))) if errors else (np.nan, np.nan)


def unseen(held: Sequence[Trial]) -> float:
    """Return the share of frames in which nothing was told."""
    return float(np.mean([trial.unseen for trial in held])) if held else 0.0


def refused(results: Sequence[Result]) -> dict[str, str]:
    """Return those who could not be calibrated, with the sentence that says why."""
    return {r.subject.name: r.refused for r in results if r.refused}


def _base(task: str) -> str:
    """A task's name without its number of touches."""
    name, _, number = task.rpartition("-")
    return name if number.isdigit() else task
