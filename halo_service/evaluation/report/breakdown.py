"""The same figures by material, user, level and task: where they come from.

A new table is a new row of BREAKDOWNS: what to split by, and a template of figures per column.
To split by another property of the user, put it into `metrics.result.Subject`.
"""

from __future__ import annotations

import bisect
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import Any

from halo_service.evaluation.metrics.confidence import Bin, reliability
from halo_service.evaluation.metrics.pool import pool
from halo_service.evaluation.metrics.result import Result
from halo_service.evaluation.metrics.scores import Scores
from halo_service.evaluation.report import select
from halo_service.evaluation.report.figures import (
    NONE,
    ValuesOf,
    by_difficulty,
    by_level,
    by_lift,
    cell,
)
from halo_service.evaluation.report.select import Choice
from halo_service.evaluation.report.table import Table

Split = Callable[[Result, Scores], Iterable[tuple[Any, Scores]]]
"""Parts of a result's scores, each with its group."""


@dataclass(frozen=True, slots=True)
class Column:
    """One column: a template of figures, as in `figures.cell`."""

    head: str
    shown: str
    of: Choice = select.everything


@dataclass(frozen=True, slots=True)
class Breakdown:
    """One table: a row per group and method."""

    title: str
    head: str
    """Of the groups' column."""
    split: Split
    columns: tuple[Column, ...]
    note: str = ""
    of: Choice = select.everything
    label: Callable[[Any], str] = str
    """A group in words."""


def breakdown(results: Sequence[Result]) -> tuple[Table, ...]:
    """Return every table that has rows."""
    tables = [_table(each, results) for each in BREAKDOWNS]
    tables += [retaps_by_lift(results), reliability_table(results), not_calibrated(results)]
    return tuple(table for table in tables if table.rows)


def _table(plan: Breakdown, results: Sequence[Result]) -> Table:
    groups: dict[Any, dict[str, list[tuple[Result, Scores]]]] = {}
    for result in select.scored(results, plan.of):
        assert result.scores is not None  # `scored` left out the others
        for group, part in plan.split(result, result.scores):
            groups.setdefault(group, {}).setdefault(result.method, []).append((result, part))
    order = sorted(groups) if any(isinstance(each, tuple) for each in groups) else groups
    rows = [
        (plan.label(group), method, *_cells(plan.columns, groups[group][method]))
        for group in order
        for method in select.methods(results)
        if method in groups[group]
    ]
    measured = tuple(row for row in rows if set(row[2:]) != {NONE})
    return Table(
        plan.title,
        (plan.head, "method", *(each.head for each in plan.columns)),
        measured,
        plan.note,
    )


def _cells(columns: Sequence[Column], parts: Sequence[tuple[Result, Scores]]) -> list[str]:
    pools = {
        choice: ValuesOf(pool(Scores, [part for result, part in parts if choice(result)]))
        for choice in {column.of for column in columns}
    }
    return [cell(column.shown, pools[column.of]) for column in columns]


def retaps_by_lift(results: Sequence[Result]) -> Table:
    """Return the share of re-taps that each method reports, by lift."""
    by_method = {
        name: by_lift(select.pooled(select.of(results, name))) for name in select.methods(results)
    }
    lifts = sorted({lift for parts in by_method.values() for lift in parts})
    rows = (
        (f"{lift:g} mm", *(_share(parts.get(lift, Scores())) for parts in by_method.values()))
        for lift in lifts
    )
    return Table("Re-taps reported, % by lift", ("lift", *by_method), tuple(rows))


def reliability_table(results: Sequence[Result]) -> Table:
    """Return the share of the published touches that were right, by their confidence."""
    by_method = {
        name: reliability(select.pooled(select.of(results, name)).touches)
        for name in select.methods(results)
    }
    rows = (
        (f"{bins[0].least:g} to {bins[0].most:g}", *map(_of_bin, bins))
        for bins in zip(*by_method.values(), strict=True)
        if any(each.reported for each in bins)
    )
    return Table(
        "Reliability of the confidence: right touches, % by confidence",
        ("confidence", *by_method),
        tuple(rows),
        "All tasks. Right: hits at most 8 mm off. A method is calibrated where the share is the "
        "confidence: of the touches reported with 0.9, 90 % are right.",
    )


def _of_bin(bin_: Bin) -> str:
    return f"{bin_.share:.0%} of {bin_.reported}" if bin_.reported else NONE


def _share(scores: Scores) -> str:
    return cell("{retaps_reported_share:.1%}", ValuesOf(scores))


def not_calibrated(results: Sequence[Result]) -> Table:
    """Return who was refused, and why."""
    why = {(r.subject.name, r.method): r.refused for r in results if r.refused}
    rows = tuple((name, method, words) for (name, method), words in why.items())
    return Table("Could not be calibrated", ("user", "method", "reason"), rows)


def _by(key: Callable[[Result], str]) -> Split:
    """Split by a property of the result, such as its user's material."""
    return lambda result, scores: [(key(result) or NONE, scores)]


def _has_targets(result: Result) -> bool:
    return select.pointing(result) and bool(result.scores and result.scores.touches.true)


def _level_words(group: tuple[str, float]) -> str:
    kind, level = group
    return f"{kind}, {level:g} {'mm' if kind == 'hover' else 'g'}"


def _difficulty_words(group: tuple[str, float]) -> str:
    kind, value = group
    return f"pitch, {value:g}°" if kind == "angle" else f"beyond the edge, {value:g} mm"


def _task_words(task: str) -> str:
    names = ("T1 accurate", "T2 balanced", "T3 fast")
    return dict(zip(select.TYPING, names, strict=True)).get(task, task)


def _columns(*columns: tuple[str, str]) -> tuple[Column, ...]:
    return tuple(Column(head, shown) for head, shown in columns)


def _at_both_noises(*columns: tuple[str, str]) -> tuple[Column, ...]:
    return tuple(
        Column(head + words, shown, choice)
        for head, shown in columns
        for words, choice in (("", select.plain_noise), (", doubled noise", select.doubled_noise))
    )


CLASSES: dict[str, tuple[float, ...]] = {
    "skin_offset_mm": (7.0, 9.0, 11.0),
    "curl": (0.2, 0.5, 0.8),
    "height_mm": (450.0, 600.0, 800.0),
}
"""Bounds between the classes of a property that is a number."""
PROPERTIES = {
    "halo": "halo", "skin_offset_mm": "skin offset, mm", "curl": "curl",
    "height_mm": "camera height, mm", "mode": "depth mode", "device": "device",
}  # fmt: skip


def _by_properties(result: Result, scores: Scores) -> list[tuple[tuple[str, int, str], Scores]]:
    """Count the scores once in each property of the user and the camera."""
    groups = []
    for name, words in PROPERTIES.items():
        value = getattr(result.subject, name)
        if value is None or value == "":
            continue  # a recording: its user is unknown
        order, class_words = _class(name, value)
        groups.append(((words, order, class_words), scores))
    return groups


def _class(name: str, value: float | str) -> tuple[int, str]:
    """Return the place of a value's class among the others, and its name."""
    if isinstance(value, str):
        return 0, value
    bounds = CLASSES[name]
    index = bisect.bisect_right(bounds, value)
    if index == 0:
        return index, f"below {bounds[0]:g}"
    if index == len(bounds):
        return index, f"from {bounds[-1]:g}"
    return index, f"{bounds[index - 1]:g} to {bounds[index]:g}"


def _property_words(group: tuple[str, int, str]) -> str:
    name, _, words = group
    return f"{name}: {words}"


PLACE = "{spatial_mean_mm:.1f} ± {spatial_sd_mm:.1f}"
HOVER = "{hover_error_mm:.2f} ± {hover_error_sd_mm:.2f}"
PRESSURE = "{pressure_error_percent:.2f} ± {pressure_error_sd_percent:.2f}"
LEVELS = _at_both_noises(("hover, mm", HOVER), ("pressure, %", PRESSURE))
BREAKDOWNS = (
    Breakdown(
        "Touches by material",
        "material",
        _by(lambda result: result.subject.material),
        _columns(
            ("touches", "{touches}"), ("precision, %", "{precision:.2%}"),
            ("recall, %", "{recall:.2%}"), ("F1, %", "{f1:.2%}"), ("missed", "{missed}"),
            ("doubled", "{doubled}"), ("outside", "{outside}"), ("ghosts", "{ghosts}"),
            ("error, mm", PLACE),
            ("median p95, mm", "{spatial_median_mm:.1f} {spatial_p95_mm:.1f}"),
            ("bias x y, mm", "{spatial_bias_x_mm:+.1f} {spatial_bias_y_mm:+.1f}"),
            ("95 % ellipse, mm",
             "{spatial_ellipse_long_mm:.0f} x {spatial_ellipse_short_mm:.0f}"),
        ),
        "Ghosts and touches outside count against precision; the paper counted doubled ones only.",
        _has_targets,
    ),
    Breakdown(
        "Hover by level", "level",
        lambda result, scores: [g for g in by_level(scores).items() if g[0][0] == "hover"],
        _at_both_noises(("error, mm", HOVER), ("bias, mm", "{hover_bias_mm:+.2f}")),
        "Bias: reported minus true.",
        label=_level_words,
    ),
    Breakdown(
        "Pressure by level", "level",
        lambda result, scores: [g for g in by_level(scores).items() if g[0][0] == "pressure"],
        _at_both_noises(("error, %", PRESSURE), ("bias, %", "{pressure_bias_percent:+.2f}")),
        "In % of 385 g. Bias: reported minus true.",
        label=_level_words,
    ),
    Breakdown(
        "By property of user and camera", "property", _by_properties,
        _columns(
            ("touches", "{touches}"), ("F1, %", "{f1:.2%}"), ("missed", "{missed}"),
            ("doubled", "{doubled}"), ("outside", "{outside}"), ("ghosts", "{ghosts}"),
            ("error, mm", PLACE), ("hover, mm", HOVER), ("pressure, %", PRESSURE),
        ),
        "All tasks together. Curl: of the other fingers, 0 hanging, 1 a fist. Each user counts in "
        "one row of each property, so the properties are not independent.",
        label=_property_words,
    ),
    Breakdown("Hover and pressure error by family of curves", "family",
              _by(lambda result: result.subject.family), LEVELS),
    Breakdown("Hover and pressure error by user", "user",
              _by(lambda result: result.subject.name), LEVELS),
    Breakdown(
        "Typing", "task", _by(lambda result: result.task),
        _columns(
            ("WPM", "{wpm:.1f}"), ("AWPM", "{awpm:.1f}"), ("perfect AWPM", "{perfect_awpm:.1f}"),
            ("uncorrected, %", "{uncorrected_share:.1%}"),
            ("perfect, %", "{perfect_uncorrected_share:.1%}"),
            ("corrected, %", "{corrected_share:.1%}"), ("keys inside", "{keys_struck}"),
            ("wrong", "{keys_wrong}"), ("missed", "{keys_missed}"), ("doubled", "{keys_doubled}"),
        ),
        "Perfect: what a perfect sensor would type from the same touches. Keys inside: struck at "
        "least 2 mm inside a key; the counts after it are of those. The virtual typist never "
        "deletes.",
        lambda result: bool(result.scores and result.scores.phrases),
        _task_words,
    ),
    Breakdown(
        "Touches that are difficult to see", "what",
        lambda result, scores: by_difficulty(scores).items(),
        _columns(
            ("touches", "{touches}"), ("missed", "{missed}"),
            ("wrong, high confidence", "{wrong_high_confidence}"),
            ("wrong, low confidence", "{wrong_low_confidence}"), ("error, mm", PLACE),
        ),
        "Beyond the edge: negative inside the surface. Wrong: doubled, outside, reported for the "
        "feint before the touch, or more than 8 mm off. High confidence: at least 0.75, or none "
        "published.",
        label=_difficulty_words,
    ),
    Breakdown(
        "Behaviour by task", "task", _by(lambda result: result.task),
        _columns(
            ("touches", "{touches}"), ("missed", "{missed}"), ("doubled", "{doubled}"),
            ("outside", "{outside}"), ("ghosts", "{ghosts}"), ("wrong finger", "{wrong_finger}"),
            ("stuck", "{stuck}"), ("id changes", "{id_changes}"), ("stray, %", "{stray_share:.1%}"),
            ("without pointer, %", "{without_pointer_share:.1%}"),
            ("hover jumps, mm", "{hover_jump_p99_mm:.1f}, {hover_jump_largest_mm:.1f}"),
        ),
        "Stray: pointers where no finger is. Without pointer: active low fingers that have none. "
        "Hover jumps: the change from frame to frame beyond the finger's own, 99th percentile and "
        "largest.",
    ),
)  # fmt: skip
