"""Results of a session as a table: a row for each phrase, and one for each task.

Rule: pure, but for `write_results`. Rates follow Zhang and Wobbrock (2019), see `metrics`.
"""

from __future__ import annotations

import csv
import io
from collections.abc import Callable, Sequence
from pathlib import Path
from statistics import fmean

from halo_client.files import appearing
from halo_type.typist import Result

MEAN = "mean"
"""In the column `phrase`: the row of a task."""
FIGURES: dict[str, Callable[[Result], float]] = {
    "seconds": lambda result: result.seconds,
    "wpm": lambda result: result.typed.wpm,
    "accuracy": lambda result: result.typed.accuracy,
    "awpm": lambda result: result.typed.awpm,
    "uncorrected_error_rate": lambda result: result.typed.uncorrected_rate,
    "corrected_error_rate": lambda result: result.typed.corrected_rate,
    "correct": lambda result: result.typed.correct,
    "uncorrected": lambda result: result.typed.uncorrected,
    "corrected": lambda result: result.typed.corrected,
}
COLUMNS = ("participant", "task", "phrase", "presented", "transcribed", *FIGURES)


def to_csv(results: Sequence[Result], participant: str = "") -> str:
    """Return the table; the row of a task holds the means of its phrases."""
    text = io.StringIO()
    table = csv.writer(text, lineterminator="\n")
    table.writerow(COLUMNS)
    for task in dict.fromkeys(result.trial.task for result in results):
        mine = [result for result in results if result.trial.task == task]
        for result in mine:
            words = (result.trial.number, result.trial.presented, result.transcribed)
            table.writerow([participant, task, *words, *_figures([result])])
        table.writerow([participant, task, MEAN, "", "", *_figures(mine)])
    return text.getvalue()


def write_results(path: Path, results: Sequence[Result], participant: str = "") -> None:
    """Write the table, complete or not at all. Raises `OSError`."""
    with appearing(path) as file:
        file.write(to_csv(results, participant).encode())


def summary(results: Sequence[Result]) -> list[str]:
    """Return a sentence for each task."""
    return [
        f"{task}: {len(mine)} phrase{'s' if len(mine) > 1 else ''}, "
        f"{_mean(mine, 'wpm'):.1f} words a minute, accuracy {100 * _mean(mine, 'accuracy'):.1f} %, "
        f"AWPM {_mean(mine, 'awpm'):.1f}, "
        f"uncorrected errors {100 * _mean(mine, 'uncorrected_error_rate'):.1f} %, "
        f"corrected {100 * _mean(mine, 'corrected_error_rate'):.1f} %"
        for task in dict.fromkeys(result.trial.task for result in results)
        if (mine := [result for result in results if result.trial.task == task])
    ]


def _figures(results: Sequence[Result]) -> list[str]:
    return [f"{_mean(results, name):.6g}" for name in FIGURES]


def _mean(results: Sequence[Result], name: str) -> float:
    return fmean(FIGURES[name](result) for result in results)
