"""The table of `halo bench`. Pure."""

from __future__ import annotations

from halo_service.evaluation.latency.figures import Case, Spread, goals

HANDS = {1: "one hand", 2: "two hands"}
BUSY_MS = 0.5
"""If frames wait longer than this for a core, the median shows the machine, not our code."""
LAST_STAGES = 2
"""Encoding and sending: the last stages of both pipelines."""


def table(case: Case) -> list[str]:
    """Return the lines of one case."""
    ours, sequential = case.ours, case.sequential
    return [
        "",
        f"{HANDS.get(case.hands, f'{case.hands} hands')}: {case.source}",
        f"{'ms':24}{'ours':>24}{'sequential':>24}",
        f"{'':24}" + 2 * f"{'median':>8}{'p95':>8}{'p99':>8}" + f"{'ratio':>8}",
        _row("received -> sent", ours.latency, sequential.latency) + f"{case.ratio:8.1f}",
        *(
            _row(f"  {name}", ours.stages.get(name), sequential.stages.get(name))
            for name in _stages(case)
        ),
        *_hands(ours.hands),
        _pair("CPU of a frame", ours.cpu_a_frame, sequential.cpu_a_frame),
        _pair("  frame to packet", ours.path_cpu_a_frame, sequential.path_cpu_a_frame),
        _sent("frames sent", ours.frames, sequential.frames),
        _sent("  dropped, too late", ours.dropped, sequential.dropped),
        _sent("  received", ours.received, sequential.received),
        *_contacts(case),
        *_disturbed(case),
        "goals",
        *(
            f"  {goal.name:34}{goal.value:8.2f}  {goal.limit:10} "
            f"{'pass' if goal.passed else 'fail'}"
            for goal in goals(case)
        ),
    ]


def _stages(case: Case) -> list[str]:
    """Return the stages of both, in an order that fits each."""
    names = list(case.sequential.stages)
    alone = [name for name in case.ours.stages if name not in names]
    return [*names[:-LAST_STAGES], *alone, *names[-LAST_STAGES:]]


def _row(name: str, ours: Spread | None, sequential: Spread | None) -> str:
    return f"{name:24}" + "".join(
        f"{'-':>8}{'-':>8}{'-':>8}"
        if spread is None
        else f"{spread.median:8.2f}{spread.p95:8.2f}{spread.p99:8.2f}"
        for spread in (ours, sequential)
    )


def _hands(ages: Spread | None) -> list[str]:
    """Return the age of the hands in a frame; 0 for a pipeline that waits for them."""
    return [] if ages is None else [_pair("age of the hands", ages.median, 0.0)]


def _pair(name: str, ours: float, sequential: float) -> str:
    return f"{name:24}{ours:8.1f}{'':16}{sequential:8.1f}"


def _sent(name: str, ours: int, sequential: int) -> str:
    return f"{name:24}{ours:8}{'':16}{sequential:8}"


def _contacts(case: Case) -> list[str]:
    if case.contacts is None:
        return []
    contacts = case.contacts
    return [
        f"contact -> down: median {contacts.median_ms:.1f} ms "
        f"({contacts.median_frames:.2f} frames), p95 {contacts.p95_ms:.1f} ms; "
        f"{contacts.reported} of {contacts.true} reported, {contacts.early} before contact"
    ]


def _disturbed(case: Case) -> list[str]:
    waited = case.ours.core_wait_a_frame
    if waited is None or waited <= BUSY_MS:
        return []
    return [
        f"note: our frames waited {waited:.1f} ms for a free core; another program or our hand "
        "tracker used it"
    ]
