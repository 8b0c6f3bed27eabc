"""What is printed of results: who was measured and with what, then the tables."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence

from halo_service.evaluation.metrics.result import Result
from halo_service.evaluation.report.breakdown import breakdown
from halo_service.evaluation.report.goals import VIRTUAL, goal_table
from halo_service.evaluation.report.table import Table
from halo_service.evaluation.study.plan import REPORTED, TUNED

Lay = Callable[[Table], str]


def told(results: Sequence[Result], version: str, lay: Lay) -> Iterator[str]:
    """Yield paragraphs. `lay`: how a table is laid out; `version`: of the package."""
    yield "\n".join(heading(results, version))
    for table in (goal_table(results, note(results)), *breakdown(results)):
        yield lay(table)


def note(results: Sequence[Result]) -> str:
    """Say how the table is to be read: whose figures stand in it."""
    if not is_recording(results):
        return VIRTUAL
    whose = (
        f"The paper's figures are of a whole study, the others of one recording, judged by "
        f"{_judge(results)}."
    )
    remarks = dict.fromkeys(each.remark for each in results if each.remark)
    return " ".join((whose, *remarks))


def is_recording(results: Sequence[Result]) -> bool:
    """Say whether the results are of one recording, and not of a study."""
    return any(each.subject.seed is None for each in results)


def heading(results: Sequence[Result], version: str) -> Iterator[str]:
    """Say who was measured, and with what."""
    settings = sorted({each.settings for each in results if each.settings})
    yield f"halo-service {version}, configuration {', '.join(settings) or 'of nobody'}"
    seeds = sorted({each.subject.seed for each in results if each.subject.seed is not None})
    if seeds:
        materials = dict.fromkeys(each.subject.material for each in results)
        yield f"virtual users {_numbers(seeds)} on {', '.join(materials)}"
        yield f"tuned on users {_numbers(TUNED)}; to be reported: {_numbers(REPORTED)}"
        if not set(seeds) <= set(REPORTED):
            yield "these are no reported users: the figures watch over changes and prove nothing"
        if not any(each.task.startswith("labels") for each in results):
            yield "real people's tap timing was left out: the full study has it with --labels DIR"
    if is_recording(results):
        names = ", ".join(dict.fromkeys(each.subject.name for each in results))
        yield f"recording {names}, judged by {_judge(results)}"


def _judge(results: Sequence[Result]) -> str:
    if any(each.asked for each in results):
        return "what was asked for, with people's own errors in it"
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
