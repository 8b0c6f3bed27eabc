"""The tables of `halo bench`. Pure."""

from __future__ import annotations

from collections.abc import Iterator

from halo_service.evaluation.latency.figures import Case, Spread, goals
from halo_service.evaluation.report.table import Table

HANDS = {1: "one hand", 2: "two hands"}
BUSY_MS = 0.5
"""If frames wait longer than this for a core, the median shows the machine, not our code."""
LAST_STAGES = 2
"""Encoding and sending: the last stages of both pipelines."""
HEAD = ("ms", "ours: median", "p95", "p99", "sequential: median", "p95", "p99", "ratio")
NO_SPREAD = ("-", "-", "-")


def lines(case: Case) -> list[str]:
    """Return the lines of one case, for programs and for files."""
    heads = ("", *2 * ("median", "p95", "p99"), "ratio")
    return [
        "",
        _title(case),
        f"{'ms':24}{'ours':>24}{'sequential':>24}",
        *(_line(row) for row in (heads, *_rows(case))),
        *_remarks(case),
        "goals",
        *(
            f"  {name:34}{value:>8}  {limit:10} {verdict}"
            for name, value, limit, verdict in _goals(case)
        ),
    ]


def tables(case: Case) -> tuple[Table, Table]:
    """Return the times of one case, and its goals."""
    times = Table(_title(case), HEAD, tuple(_rows(case)), " ".join(_remarks(case)))
    return times, Table("", ("goal", "value", "limit", ""), tuple(_goals(case)))


def _title(case: Case) -> str:
    return f"{HANDS.get(case.hands, f'{case.hands} hands')}: {case.source}"


def _line(row: tuple[str, ...]) -> str:
    name, *figures = row
    return (f"{name:24}" + "".join(f"{figure:>8}" for figure in figures)).rstrip()


def _rows(case: Case) -> Iterator[tuple[str, ...]]:
    """Yield as many cells as `HEAD` has."""
    ours, sequential = case.ours, case.sequential
    yield (*_spreads("received -> sent", ours.latency, sequential.latency), f"{case.ratio:.1f}")
    for name in _stages(case):
        yield (*_spreads(f"  {name}", ours.stages.get(name), sequential.stages.get(name)), "")
    if ours.hands is not None:
        # The other pipeline waits for the hands, so it always has those of its frame.
        yield _pair("age of the hands", f"{ours.hands.median:.1f}", "0.0")
    yield _pair("CPU of a frame", f"{ours.cpu_a_frame:.1f}", f"{sequential.cpu_a_frame:.1f}")
    yield _pair(
        "  frame to packet", f"{ours.path_cpu_a_frame:.1f}", f"{sequential.path_cpu_a_frame:.1f}"
    )
    yield _pair("frames sent", str(ours.frames), str(sequential.frames))
    yield _pair("  dropped, too late", str(ours.dropped), str(sequential.dropped))
    yield _pair("  received", str(ours.received), str(sequential.received))


def _goals(case: Case) -> Iterator[tuple[str, str, str, str]]:
    for goal in goals(case):
        yield goal.name, f"{goal.value:.2f}", goal.limit, "pass" if goal.passed else "fail"


def _stages(case: Case) -> list[str]:
    """Return the stages of both, in an order that fits each."""
    names = list(case.sequential.stages)
    alone = [name for name in case.ours.stages if name not in names]
    return [*names[:-LAST_STAGES], *alone, *names[-LAST_STAGES:]]


def _spreads(name: str, ours: Spread | None, sequential: Spread | None) -> tuple[str, ...]:
    return (name, *_spread(ours), *_spread(sequential))


def _spread(spread: Spread | None) -> tuple[str, str, str]:
    if spread is None:
        return NO_SPREAD
    return f"{spread.median:.2f}", f"{spread.p95:.2f}", f"{spread.p99:.2f}"


def _pair(name: str, ours: str, sequential: str) -> tuple[str, ...]:
    return name, ours, "", "", sequential, "", "", ""


def _remarks(case: Case) -> Iterator[str]:
    if (contacts := case.contacts) is not None:
        yield (
            f"contact -> down: median {contacts.median_ms:.1f} ms "
            f"({contacts.median_frames:.2f} frames), p95 {contacts.p95_ms:.1f} ms; "
            f"{contacts.reported} of {contacts.true} reported, {contacts.early} before contact"
        )
    waited = case.ours.core_wait_a_frame
    if waited is not None and waited > BUSY_MS:
        yield (
            f"note: our frames waited {waited:.1f} ms for a free core; another program or our hand "
            "tracker used it"
        )
