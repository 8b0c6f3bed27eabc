"""What is printed of results: who was measured with what, the tables, or one short line each."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

from halo_service.evaluation.metrics.result import Result
from halo_service.evaluation.metrics.scores import Scores
from halo_service.evaluation.report.breakdown import breakdown
from halo_service.evaluation.report.figures import LEVEL_FIGURES, NONE, ValuesOf, by_level, cell
from halo_service.evaluation.report.goals import VIRTUAL, goal_table
from halo_service.evaluation.report.table import Table, as_markdown
from halo_service.evaluation.study.plan import REPORTED, TUNED

LINE = (
    "{touches} touches: {missed} missed, {doubled} doubled, {outside} outside, {ghosts} ghosts, "
    "F1 {f1:.1%}",
    "{spatial_mean_mm:.1f} mm off, median {spatial_median_mm:.1f}, "
    "bias {spatial_bias_x_mm:+.1f} {spatial_bias_y_mm:+.1f}",
    "{down_frames_median:g} frames, {down_ms_median:.0f} ms late",
    "{stuck} stuck, {id_changes} id changes, {stray_share:.1%} % stray, "
    "{without_pointer_share:.1%} % without pointer",
)
"""Parts of the line of a task with touches."""


def tables(results: Sequence[Result]) -> tuple[Table, ...]:
    """Return the table of goals, then those of the breakdown."""
    return (goal_table(results, note(results)), *breakdown(results))


def results_file(results: Sequence[Result], facts: Mapping[str, str]) -> str:
    """Return a Markdown page for `docs/results`; `facts`: command, date, commit, machine ..."""
    lines = [f"- {name}: {words}" for name, words in facts.items()]
    parts = ["# Evaluation results", "\n".join(lines), *map(as_markdown, tables(results))]
    return "\n\n".join(parts) + "\n"


def brief(results: Sequence[Result]) -> Iterator[str]:
    """Yield one line per user, task and method: for a look while the sensing is changed."""
    for each in results:
        who = f"{each.subject.name:<12} {each.task:<15} {each.method:<7}"
        if each.scores is None:
            yield f"{who} cannot be calibrated: {each.refused}"
        else:
            for words in filter(None, (_touches(each.scores), _levels(each.scores))):
                yield f"{who} {words}"


def note(results: Sequence[Result]) -> str:
    """Say how to read the table."""
    if not is_recording(results):
        return VIRTUAL
    first = (
        f"The paper's figures are of a whole study, the others of one recording, compared with "
        f"{_reference(results)}."
    )
    remarks = dict.fromkeys(each.remark for each in results if each.remark)
    return " ".join((first, *remarks))


def is_recording(results: Sequence[Result]) -> bool:
    """Whether the results are of one recording, and not of a study."""
    return any(each.subject.seed is None for each in results)


def heading(results: Sequence[Result], version: str) -> Iterator[str]:
    """Say who was measured, and with what."""
    settings = sorted({each.settings for each in results if each.settings})
    yield f"halo-service {version}, configuration {', '.join(settings) or NONE}"
    seeds = sorted({each.subject.seed for each in results if each.subject.seed is not None})
    if seeds:
        materials = dict.fromkeys(each.subject.material for each in results)
        yield f"virtual users {_numbers(seeds)} on {', '.join(materials)}"
        yield f"tuning users: {_numbers(TUNED)}; reported users: {_numbers(REPORTED)}"
        if not set(seeds) <= set(REPORTED):
            yield "tuning users; use only to spot regressions"
        if not any(each.task.startswith("labels") for each in results):
            yield "without real people's tap timing: give the full study --labels DIR for it"
    if is_recording(results):
        names = ", ".join(dict.fromkeys(each.subject.name for each in results))
        yield f"recording {names}, compared with {_reference(results)}"


def _touches(scores: Scores) -> str:
    if not scores.touches.true:
        ghosts = len(scores.touches.ghosts)
        return f"no touch, {ghosts} ghosts" if ghosts else ""
    values = ValuesOf(scores)
    return " | ".join(words for part in LINE if (words := cell(part, values)) != NONE)


def _levels(scores: Scores) -> str:
    if not scores.trials:
        return ""
    kind = scores.trials[0].kind
    unit = "mm" if kind == "hover" else "% of 385 g"
    mean = f"{{{LEVEL_FIGURES[kind][0]}:.2f}}"
    levels = ", ".join(
        f"{level:g}: {cell(mean, ValuesOf(part))}" for (_, level), part in by_level(scores).items()
    )
    values = ValuesOf(scores)
    silent = cell(f"{{{kind}_no_reading_share:.1%}} % without reading", values)
    return f"{kind} error {cell(mean, values)} {unit} ({levels}), {silent}"


def _reference(results: Sequence[Result]) -> str:
    if any(each.by_script for each in results):
        return "its script, so with people's own errors"
    return "its truth"


def _numbers(numbers: Sequence[int]) -> str:
    """Write 1, 2, 3, 7 as 1-3, 7."""
    runs: list[list[int]] = []
    for number in numbers:
        if runs and number == runs[-1][-1] + 1:
            runs[-1].append(number)
        else:
            runs.append([number])
    return ", ".join(f"{run[0]}-{run[-1]}" if len(run) > 1 else f"{run[0]}" for run in runs)
