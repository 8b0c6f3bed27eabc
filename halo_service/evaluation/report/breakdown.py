"""The same figures by material, family of halo curves, user and task: where they come from."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from itertools import chain

import numpy as np

from halo_service.evaluation.metrics.confidence import FAR_MM, SURE, score_sureness
from halo_service.evaluation.metrics.difficult import by_value
from halo_service.evaluation.metrics.keystrokes import Keys, Phrase
from halo_service.evaluation.metrics.levels import Trial
from halo_service.evaluation.metrics.result import Result
from halo_service.evaluation.metrics.retaps import told_by_lift
from halo_service.evaluation.metrics.scores import Scores
from halo_service.evaluation.metrics.spatial import Spatial, from_truth, spatial
from halo_service.evaluation.report import select
from halo_service.evaluation.report.table import Table

NONE = "-"
"""What stands where nothing was measured."""
LEVELS = (("hover", False), ("hover", True), ("pressure", False), ("pressure", True))
LEVEL_HEAD = ("hover, mm", "at doubled noise", "pressure, %", "at doubled noise")
AWKWARD = {"angle": "pitch, {:g}°", "edge": "off the edge, {:g} mm"}
TASK_NAMES = dict(zip(select.TYPING, ("T1 accurate", "T2 balanced", "T3 fast"), strict=True))

Key = Callable[[Result], str]


def breakdown(results: Sequence[Result]) -> tuple[Table, ...]:
    """Return every table that the results have rows for."""
    tables = (
        touches_by_material(results),
        levels_by_height_and_force(results),
        levels_by_family(results),
        levels_by_user(results),
        typing_by_task(results),
        retaps_by_lift(results),
        hard_by_angle_and_edge(results),
        conduct_by_task(results),
        not_calibrated(results),
    )
    return tuple(table for table in tables if table.rows)


def touches_by_material(results: Sequence[Result]) -> Table:
    """Target pointing on each material."""
    rows = []
    for material, method, mine in _grouped(results, lambda result: result.subject.material):
        told = select.touches(select.pointing(mine))
        if told.true:
            rows.append(
                (
                    material or NONE,
                    method,
                    str(told.true),
                    *(f"{100 * share:.2f}" for share in (told.precision, told.recall, told.f1)),
                    *(str(len(each)) for each in (told.missed, told.doubled, told.outside)),
                    str(len(told.ghosts)),
                    *_off(spatial(from_truth(told.hits))),
                )
            )
    return Table(
        "Touches by material",
        _head(
            "material|method|touches|precision, %|recall, %|F1, %|missed|doubled|outside|ghosts|"
            "off by, mm|median p95, mm|bias x y, mm|95 % ellipse, mm"
        ),
        tuple(rows),
        "Ghosts and what lay outside count against precision; the paper counted doubled ones only.",
    )


def levels_by_height_and_force(results: Sequence[Result]) -> Table:
    """Error and bias at each held height and force."""
    rows = []
    for kind, unit in (("hover", "mm"), ("pressure", "g")):
        held = {
            (method, noisy): select.trials(select.of(results, method), kind, noisy)
            for method in select.methods(results)
            for noisy in (False, True)
        }
        for level in sorted({trial.level for trials in held.values() for trial in trials}):
            for method in select.methods(results):
                cells = (_at_level(held[method, noisy], level) for noisy in (False, True))
                rows.append((f"{kind}, {level:g} {unit}", method, *chain.from_iterable(cells)))
    return Table(
        "Hover and pressure by level",
        _head("level|method|error|bias|error at doubled noise|bias at doubled noise"),
        tuple(rows),
        "Hover in mm, pressure in % of 385 g. Bias: told minus true.",
    )


def levels_by_family(results: Sequence[Result]) -> Table:
    """Hover and pressure for each family of halo curves."""
    rows = _levels(results, lambda result: result.subject.family)
    return Table(
        "Hover and pressure error by family of curves", ("family", "method", *LEVEL_HEAD), rows
    )


def levels_by_user(results: Sequence[Result]) -> Table:
    """Hover and pressure for each user."""
    rows = _levels(results, lambda result: result.subject.name)
    return Table("Hover and pressure error by user", ("user", "method", *LEVEL_HEAD), rows)


def typing_by_task(results: Sequence[Result]) -> Table:
    """The three typing tasks."""
    rows = []
    for task, method, mine in _grouped(results, lambda result: result.task):
        phrases = [phrase for r in mine if r.scores for phrase in r.scores.phrases]
        if phrases:
            keys = sum((r.scores.keys for r in mine if r.scores), Keys())
            counts = keys.struck, keys.wrong, keys.missed, keys.doubled
            rows.append(
                (TASK_NAMES.get(task, task), method, *_text_rates(phrases), *map(str, counts))
            )
    return Table(
        "Typing",
        _head(
            "task|method|WPM|AWPM|perfect AWPM|uncorrected, %|perfect, %|corrected, %|keys inside|"
            "wrong|missed|doubled"
        ),
        tuple(rows),
        "Perfect: what the same fingers would have typed had each touch been told where it was. "
        "Keys inside: struck at least 2 mm inside; the counts after it are of those. The virtual "
        "typist never deletes.",
    )


def retaps_by_lift(results: Sequence[Result]) -> Table:
    """Re-taps told, by how far the finger rose between."""
    retaps = [r for r in results if r.scores and r.scores.retaps]
    lifts = sorted({each.lift_mm for r in retaps if r.scores for each in r.scores.retaps})
    rows = []
    for _, method, mine in _grouped(retaps, lambda _: ""):
        shares = told_by_lift([each for r in mine if r.scores for each in r.scores.retaps])
        rows.append((method, *(f"{100 * shares[lift]:.1f}" for lift in lifts)))
    head = ("method", *(f"{lift:g} mm" for lift in lifts))
    return Table("Re-taps told, % by lift", head, tuple(rows))


def hard_by_angle_and_edge(results: Sequence[Result]) -> Table:
    """Touches that are hard to see, by pitch and by way off the edge."""
    known = {
        method: by_value(
            [each for r in select.of(results, method) if r.scores for each in r.scores.awkward]
        )
        for method in select.methods(results)
    }
    rows = []
    for kind, value in sorted({each for by in known.values() for each in by}):
        for method in (method for method, by in known.items() if (kind, value) in by):
            touches = known[method][kind, value]
            told = score_sureness(touches)
            counts = (
                touches.true, len(touches.hits), len(touches.missed),
                told.wrong_surely, told.wrong_unsurely,
            )  # fmt: skip
            off_by, *_ = _off(spatial(from_truth(touches.hits)))
            rows.append((AWKWARD[kind].format(value), method, *map(str, counts), off_by))
    return Table(
        "Touches that are hard to see",
        _head("what|method|touches|told|missed|wrong, surely|wrong, unsurely|off by, mm"),
        tuple(rows),
        "Off the edge: negative inside the surface. Wrong: doubled, outside or of the feint before "
        f"each touch, and of those told what was told farther than {FAR_MM:g} mm off. Surely: with "
        f"a confidence of at least {SURE:g}, or without any.",
    )


def conduct_by_task(results: Sequence[Result]) -> Table:
    """What more than a pointing finger does, and how pointers behave in every task."""
    rows = []
    for task, method, mine in _grouped(results, lambda result: result.task):
        scores = [r.scores for r in mine if r.scores]
        told = select.touches(scores)
        conduct = [each.conduct for each in scores]
        if conduct:
            strange = sum(c.strange for c in conduct) / max(sum(c.pointers for c in conduct), 1)
            unseen = sum(c.unseen for c in conduct) / max(sum(c.fingers for c in conduct), 1)
            counts = (
                told.true, len(told.missed), len(told.doubled), len(told.outside),
                len(told.ghosts), sum(c.misnamed for c in conduct), sum(c.stuck for c in conduct),
                sum(c.id_changes for c in conduct),
            )  # fmt: skip
            shares = f"{100 * strange:.1f}", f"{100 * unseen:.1f}"
            rows.append((task, method, *map(str, counts), *shares, _jumps(scores)))
    return Table(
        "Conduct by task",
        _head(
            "task|method|touches|missed|doubled|outside|ghosts|misnamed|stuck|id changes|"
            "strange, %|unseen, %|hover jumps, mm"
        ),
        tuple(rows),
        "Strange: pointers where no finger is. Unseen: low fingers that play, without a pointer. "
        "Hover jumps: the change from frame to frame beyond the finger's own, 99th percentile and "
        "largest.",
    )


def not_calibrated(results: Sequence[Result]) -> Table:
    """Who was refused, and why."""
    why = {(r.subject.name, r.method): r.refused for r in results if r.refused}
    rows = tuple((name, method, words) for (name, method), words in why.items())
    return Table("Could not be calibrated", ("who", "method", "why"), rows)


def _head(words: str) -> tuple[str, ...]:
    return tuple(words.split("|"))


def _grouped(results: Sequence[Result], key: Key) -> Iterator[tuple[str, str, list[Result]]]:
    """Yield the results that share a key and a method, methods side by side."""
    for name in dict.fromkeys(key(result) for result in results):
        for method in select.methods(results):
            yield name, method, [r for r in results if key(r) == name and r.method == method]


def _levels(results: Sequence[Result], key: Key) -> tuple[tuple[str, ...], ...]:
    rows = []
    for name, method, mine in _grouped(results, key):
        errors = [select.mean_error(select.trials(mine, *level)) for level in LEVELS]
        cells = [NONE if np.isnan(mean) else f"{mean:.2f} ± {sd:.2f}" for mean, sd in errors]
        if set(cells) != {NONE}:
            rows.append((name or NONE, method, *cells))
    return tuple(rows)


def _at_level(trials: Sequence[Trial], level: float) -> tuple[str, str]:
    mine = [each for each in trials if each.level == level and not np.isnan(each.error)]
    mean, sd = select.mean_error(mine)
    if not mine:
        return NONE, NONE
    return f"{mean:.2f} ± {sd:.2f}", f"{np.mean([each.bias for each in mine]):+.2f}"


def _off(off: Spatial | None) -> tuple[str, str, str, str]:
    if off is None:
        return NONE, NONE, NONE, NONE
    return (
        f"{off.mean_mm:.1f} ± {off.sd_mm:.1f}",
        f"{off.median_mm:.1f} {off.p95_mm:.1f}",
        f"{off.bias_mm[0]:+.1f} {off.bias_mm[1]:+.1f}",
        f"{2 * off.ellipse.major_mm:.0f} x {2 * off.ellipse.minor_mm:.0f}",
    )


def _text_rates(phrases: Sequence[Phrase]) -> Iterator[str]:
    typed, perfect = [p.typed for p in phrases], [p.perfect for p in phrases]
    yield f"{np.mean([each.wpm for each in typed]):.1f}"
    yield f"{np.mean([each.awpm for each in typed]):.1f}"
    yield f"{np.mean([each.awpm for each in perfect]):.1f}"
    yield f"{100 * np.mean([each.uncorrected_rate for each in typed]):.1f}"
    yield f"{100 * np.mean([each.uncorrected_rate for each in perfect]):.1f}"
    yield f"{100 * np.mean([each.corrected_rate for each in typed]):.1f}"


def _jumps(scores: Sequence[Scores]) -> str:
    jumps = [jump.jump_mm for each in scores for jump in each.jumps]
    return f"{np.percentile(jumps, 99.0):.1f}, {max(jumps):.1f}" if jumps else NONE
