"""Where touches were reported, how many, and how late: a panel per material or method.

Rule: each function returns the drawings of one figure, none where the results hold none.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from halo_service.evaluation.metrics.confidence import reliability
from halo_service.evaluation.metrics.result import Result
from halo_service.evaluation.metrics.spatial import Errors, ellipse, from_truth
from halo_service.evaluation.metrics.timing import Timing
from halo_service.evaluation.metrics.touches import Hit
from halo_service.evaluation.report import select
from halo_service.evaluation.report.figures import ValuesOf
from halo_service.evaluation.report.goals import FRAME_MS
from halo_service.evaluation.report.svg import (
    Panel,
    axes,
    bar,
    coloured,
    cross,
    dots,
    drawing,
    line,
    oval,
    text,
    ticks,
    upright,
)

AROUND_MM = 30.0
"""Shown around the outer targets."""
CLOUD_MM = 15.0
"""Shown around the true place."""
HISTOGRAM_MS = (-40.0, 140.0)
"""What is earlier or later is drawn at the ends."""
BIN_MS = 5.0


def targets(results: Sequence[Result], method: str) -> list[str]:
    """Touches around their targets with 95 % ellipses, one panel per material."""
    drawings = []
    for material in _materials(results):
        mine = [r for r in select.of(results, method) if r.subject.material == material]
        touches = select.pooled(mine, select.pointing).touches
        hits = [hit for hit in touches.hits if hit.touch.target_mm]
        if hits:
            drawings.append(_map(material, hits, method))
    return drawings


def reliability_plot(results: Sequence[Result]) -> list[str]:
    """Share of the right touches over their confidence, one line per method."""
    panel = Panel(230.0, 230.0, (0.0, 1.0), (0.0, 105.0))
    lines = []
    for method in select.methods(results):
        touches = select.pooled(select.of(results, method)).touches
        bins = [each for each in reliability(touches) if each.reported]
        sure, right = [b.confidence for b in bins], [100.0 * b.share for b in bins]
        if bins:
            lines.append(line(panel, sure, right, coloured(method)))
            lines.append(dots(panel, sure, right, coloured(method)))
    if not lines:
        return []
    numbers = ticks(0, 0.25, 0.5, 0.75, 1)
    percents = ticks(0, 25, 50, 75, 100)
    frame = axes(panel, "", "confidence", "right, %", numbers, percents)
    diagonal = line(panel, (0.0, 1.0), (0.0, 100.0), "truth")
    return [drawing(panel, "share of right touches by confidence", [frame, diagonal, *lines])]


def clouds(results: Sequence[Result]) -> list[str]:
    """Every touch relative to its true place, one panel per method."""
    drawings = []
    for method in select.methods(results):
        errors = from_truth(select.pooled(select.of(results, method), select.pointing).touches.hits)
        if len(errors):
            drawings.append(_cloud(method, errors))
    return drawings


def accuracy(results: Sequence[Result]) -> list[str]:
    """F1 of target pointing: bars by method on each material, in one panel."""
    methods, shares = select.methods(results), {}
    for material in _materials(results):
        mine = [r for r in results if r.subject.material == material]
        touches = [select.pooled(select.of(mine, m), select.pointing).touches for m in methods]
        if any(each.true for each in touches):
            shares[material] = [100.0 * each.f1 for each in touches]
    return [_bars(methods, shares)] if shares else []


def lateness(results: Sequence[Result]) -> list[str]:
    """From contact to the frame that reported it: one histogram per method."""
    drawings = []
    for method in select.methods(results):
        scores = select.pooled(select.of(results, method), select.pointing)
        if scores.timing:
            median_ms = ValuesOf(scores)["down_ms_median"]
            drawings.append(_histogram(method, scores.timing, median_ms))
    return drawings


def _map(material: str, hits: Sequence[Hit], method: str) -> str:
    aims = sorted({hit.touch.aim_mm for hit in hits})
    (left, top), (right, bottom) = np.min(aims, axis=0), np.max(aims, axis=0)
    x, y = (left - AROUND_MM, right + AROUND_MM), (bottom + AROUND_MM, top - AROUND_MM)
    panel = Panel(270.0, 270.0 * (y[0] - y[1]) / (x[1] - x[0]), x, y)
    columns, rows = ({aim[k] for aim in aims} for k in (0, 1))
    xs, ys = [hit.down.x_mm for hit in hits], [hit.down.y_mm for hit in hits]
    parts = [
        axes(panel, material, "x, mm", "y, mm", ticks(*sorted(columns)), ticks(*sorted(rows))),
        dots(panel, xs, ys, f"small {coloured(method)}"),
    ]
    for aim in aims:
        places = np.array([(h.down.x_mm, h.down.y_mm) for h in hits if h.touch.aim_mm == aim])
        parts.append(cross(panel, *aim))
        if len(places) > 2:
            parts.append(oval(panel, ellipse(places), coloured(method)))
    return drawing(panel, f"touches around their targets on {material}", parts)


def _cloud(method: str, errors: Errors) -> str:
    panel = Panel(190.0, 190.0, (-CLOUD_MM, CLOUD_MM), (CLOUD_MM, -CLOUD_MM))
    marks = ticks(-10.0, 0.0, 10.0)
    beyond = int((np.abs(errors) > CLOUD_MM).any(axis=1).sum())
    words = f"{beyond} beyond" if beyond else ""
    parts = [
        axes(panel, method, "to the right, mm", "towards the user, mm", marks, marks),
        dots(panel, errors[:, 0].tolist(), errors[:, 1].tolist(), f"small {coloured(method)}"),
        oval(panel, ellipse(errors), coloured(method)),
        cross(panel, 0.0, 0.0),
        text(panel.px(-14.0), panel.py(-13.0), words, "number"),
    ]
    return drawing(panel, f"where {method} reported touches", parts)


def _bars(methods: Sequence[str], shares: Mapping[str, Sequence[float]]) -> str:
    panel = Panel(190.0 * len(shares), 170.0, (0.0, len(shares)), (0.0, 112.0))
    names = [(index + 0.5, material) for index, material in enumerate(shares)]
    parts = [axes(panel, "", "", "F1, %", names, ticks(0, 20, 40, 60, 80, 100))]
    wide = 0.84 / len(methods)
    for index, row in enumerate(shares.values()):
        for k, (method, share) in enumerate(zip(methods, row, strict=True)):
            left = index + 0.08 + k * wide
            parts.append(bar(panel, left, left + 0.92 * wide, share, coloured(method)))
            middle = panel.px(left + 0.46 * wide)
            parts.append(text(middle, panel.py(share) - 4.0, f"{share:.1f}", "number middle"))
    return drawing(panel, "F1 by method and material", parts)


def _histogram(method: str, timing: Sequence[Timing], median_ms: float) -> str:
    down_ms = [each.down_ms for each in timing]
    edges = np.arange(HISTOGRAM_MS[0], HISTOGRAM_MS[1] + BIN_MS, BIN_MS)
    shares = 100.0 * np.histogram(np.clip(down_ms, *HISTOGRAM_MS), edges)[0] / len(down_ms)
    top = max(10.0, 1.15 * float(shares.max()))
    panel = Panel(210.0, 120.0, HISTOGRAM_MS, (0.0, top))
    percents = ticks(*range(0, int(top), 10 if top < 45.0 else 20))
    words = f"{method}, median {median_ms:.0f} ms"
    moments = ticks(0, 33, 67, 100, 133)
    parts = [axes(panel, words, "ms after contact", "% of touches", moments, percents)]
    for left, share in zip(edges[:-1].tolist(), shares.tolist(), strict=True):
        if share:
            parts.append(bar(panel, left, left + 0.9 * BIN_MS, share, coloured(method)))
    parts.append(upright(panel, FRAME_MS, "one frame"))
    return drawing(panel, words, parts)


def _materials(results: Sequence[Result]) -> list[str]:
    return list(dict.fromkeys(result.subject.material for result in results))
