"""Which results a figure is computed from.

Rule: a recording counts for every figure that it holds anything for; a task that is harder than
the paper's counts for its own figure alone.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

from halo_service.evaluation.metrics.pool import pool
from halo_service.evaluation.metrics.result import Result
from halo_service.evaluation.metrics.scores import Scores

Choice = Callable[[Result], bool]

RECORDING = "recording"
"""The task of a recording that is no part of the study."""
TYPING = ("typing-accurate", "typing", "typing-fast")
"""The paper's T1 to T3."""


def everything(result: Result) -> bool:
    """Every task."""
    del result
    return True


def pointing(result: Result) -> bool:
    """Target pointing, with any number of touches."""
    return _base(result.task) in ("pointing", RECORDING)


def threshold(result: Result) -> bool:
    """Re-taps with small lifts."""
    return result.task in ("threshold", RECORDING)


def typing(result: Result) -> bool:
    """All typing tasks."""
    return result.task in (*TYPING, RECORDING)


def balanced_typing(result: Result) -> bool:
    """The paper's T2."""
    return result.task in ("typing", RECORDING)


def two_hands(result: Result) -> bool:
    """Tasks with more than a pointing finger."""
    return result.task in ("ten-fingers", "chaos")


def ten_fingers(result: Result) -> bool:
    """Every finger of both hands touches."""
    return result.task == "ten-fingers"


def difficult(result: Result) -> bool:
    """Touches that are difficult to see."""
    hard = result.scores is not None and bool(result.scores.difficult)
    return hard or result.task in ("awkward", "chaos")


def labelled(result: Result) -> bool:
    """Taps with real people's timing."""
    return result.task.startswith("labels")


def doubled_noise(result: Result) -> bool:
    """Tasks at twice the sensor's noise."""
    return "noise2" in result.task


def plain_noise(result: Result) -> bool:
    """All other tasks."""
    return not doubled_noise(result)


def methods(results: Sequence[Result]) -> tuple[str, ...]:
    """Return the methods in their order of appearance."""
    return tuple(dict.fromkeys(result.method for result in results))


def of(results: Sequence[Result], method: str) -> list[Result]:
    """Return one method's results."""
    return [result for result in results if result.method == method]


def scored(results: Sequence[Result], choice: Choice = everything) -> list[Result]:
    """Return the chosen results that have scores."""
    return [result for result in results if result.scores is not None and choice(result)]


def pooled(results: Sequence[Result], choice: Choice = everything) -> Scores:
    """Return the scores of the chosen results as one."""
    return pool(Scores, [result.scores for result in results if result.scores and choice(result)])


def _base(task: str) -> str:
    """A task's name without its number of touches."""
    name, _, number = task.rpartition("-")
    return name if number.isdigit() else task
