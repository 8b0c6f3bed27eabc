"""What was told of held levels and of small lifts: drawings, a panel a family of halo curves.

Rule: each returns the drawings of one figure, none where the results hold nothing for it.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from halo_service.evaluation.metrics.levels import Trial
from halo_service.evaluation.metrics.result import Result
from halo_service.evaluation.metrics.retaps import told_by_lift
from halo_service.evaluation.report import select
from halo_service.evaluation.report.svg import Panel, axes, coloured, dots, drawing, line, ticks

LEVELS = {
    "hover": ("mm", 20.0, (0, 5, 10, 15, 20)),
    "pressure": ("g", 450.0, (0, 100, 200, 300, 400)),
}
"""Unit, where the scales end, and their numbers."""


def levels(results: Sequence[Result], kind: str) -> list[str]:
    """What was told of held levels, a drawing a family of halo curves."""
    drawings = []
    for family in sorted({r.subject.family for r in results}):
        mine = [r for r in results if r.subject.family == family]
        if any(r.scores and any(t.kind == kind for t in r.scores.trials) for r in mine):
            drawings.append(_family(family, mine, kind))
    return drawings


def retaps(results: Sequence[Result]) -> list[str]:
    """Share of re-taps that were told, over how far the finger rose between."""
    panel = Panel(420.0, 170.0, (0.0, 6.5), (0.0, 105.0))
    lines = []
    for method in select.methods(results):
        parts = [r.scores.retaps for r in select.of(results, method) if r.scores]
        shares = told_by_lift([each for part in parts for each in part])
        percents = [100.0 * share for share in shares.values()]
        if shares:
            lines.append(line(panel, shares, percents, coloured(method)))
            lines.append(dots(panel, shares, percents, coloured(method)))
    if not lines:
        return []
    frame = axes(
        panel,
        "",
        "lift between two taps, mm",
        "told, %",
        ticks(*range(7)),
        ticks(0, 25, 50, 75, 99),
    )
    return [drawing(panel, "re-taps told by lift", [frame, *lines])]


def _family(family: str, results: Sequence[Result], kind: str) -> str:
    unit, end, numbers = LEVELS[kind]
    panel = Panel(230.0, 230.0, (0.0, end), (0.0, end))
    parts = [
        axes(panel, family, f"true, {unit}", f"told, {unit}", ticks(*numbers), ticks(*numbers)),
        line(panel, (0.0, end), (0.0, end), "truth"),
    ]
    for method in reversed(select.methods(results)):  # the first lies on top
        mine = select.of(results, method)
        parts.append(
            _mean_line(panel, select.trials(mine, kind, False), f"plain {coloured(method)}")
        )
        parts.append(
            _mean_line(panel, select.trials(mine, kind, True), f"noisy {coloured(method)}")
        )
    for method in select.methods(results)[:1]:
        held = select.trials(select.of(results, method), kind, False)
        held = [trial for trial in held if not np.isnan(trial.told)]
        told = [trial.told for trial in held]
        parts.append(dots(panel, [trial.level for trial in held], told, coloured(method)))
    return drawing(panel, f"{kind} with {family} curves", parts)


def _mean_line(panel: Panel, held: Sequence[Trial], kind: str) -> str:
    told = {
        level: [t.told for t in held if t.level == level and not np.isnan(t.told)]
        for level in sorted({trial.level for trial in held})
    }
    means = {level: float(np.mean(values)) for level, values in told.items() if values}
    return line(panel, means, means.values(), kind)
