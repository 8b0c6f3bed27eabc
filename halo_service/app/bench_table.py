"""What `halo bench` shows. Pure."""

from __future__ import annotations

from halo_service.evaluation.latency.figures import Case, Figures, goals

BUSY_MS = 0.5
"""Waiting for a core for longer, a frame, our median says more of the machine than of us."""
HANDS = {1: "one hand", 2: "two hands"}


def table(case: Case) -> list[str]:
    """Return the lines of one case."""
    ours, sequential = case.ours, case.sequential
    pairs = (("ours", ours), ("sequential", sequential))
    lines = [
        "",
        f"{HANDS.get(case.hands, f'{case.hands} hands')}: {case.source}",
        f"{'received -> sent, ms':24}{'median':>8}{'p95':>8}{'p99':>8}{'most':>8}",
    ]
    for name, figures in pairs:
        spread = figures.latency
        values = (spread.median, spread.p95, spread.p99, spread.most)
        lines.append(f"  {name:22}" + "".join(f"{value:8.2f}" for value in values))
    ratios = (case.ratio, sequential.latency.p95 / ours.latency.p95,
              sequential.latency.p99 / ours.latency.p99,
              sequential.latency.most / ours.latency.most)  # fmt: skip
    lines.append(f"  {'sequential / ours':22}" + "".join(f"{value:8.1f}" for value in ratios))
    lines += ["stages, ms: median, p99"]
    lines += [f"  {name:11}{_stages(figures)}" for name, figures in pairs]
    lines += ["CPU of a frame, ms; frames"]
    lines += [f"  {name:11}{_work(figures)}" for name, figures in pairs]
    if case.contacts is not None:
        told = case.contacts
        lines += [
            "contact -> down message",
            f"  ours       median {told.median_ms:.1f} ms ({told.median_frames:.2f} frames), "
            f"p95 {told.p95_ms:.1f} ms; {told.told} of {told.true} told",
        ]
    waited = ours.core_wait_a_frame
    if waited is not None and waited > BUSY_MS:
        lines += [
            f"note: others kept our frames off the cores for {waited:.1f} ms each; "
            "on a free machine all of this is faster"
        ]
    lines += ["goals"]
    lines += [
        f"  {goal.name:32}{goal.value:8.2f}  {goal.wanted:10} "
        f"{'pass' if goal.passed else 'falls short'}"
        for goal in goals(case)
    ]
    return lines


def _stages(figures: Figures) -> str:
    return "  ".join(
        f"{name} {spread.median:.2f}, {spread.p99:.2f}" for name, spread in figures.stages.items()
    )


def _work(figures: Figures) -> str:
    offered = figures.frames + figures.dropped
    return (
        f"{figures.cpu_a_frame:6.1f} in all, {figures.path_cpu_a_frame:.1f} from frame to packet; "
        f"{figures.frames} of {offered} frames sent, {figures.heard} heard"
    )
