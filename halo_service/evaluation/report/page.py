"""One HTML page, complete in itself: no script, no font and no picture from elsewhere."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from html import escape
from importlib.resources import files

from halo_service.evaluation.metrics.result import Result
from halo_service.evaluation.report import level_plots, select, touch_plots
from halo_service.evaluation.report.breakdown import breakdown
from halo_service.evaluation.report.goals import FAIL, PASS, goal_table
from halo_service.evaluation.report.summary import is_recording, note
from halo_service.evaluation.report.table import Table

TITLE = "Touch, hover and pressure, evaluated"
INTRODUCTION = (
    "The paper's study with virtual people under a virtual depth camera, sensed by every method "
    "from the same frames. What each method published is compared with the truth. These figures "
    "compare methods and say nothing about a real table."
)
RECORDED = "One recording, sensed by every method from the same frames."


def page(results: Sequence[Result], facts: Mapping[str, str]) -> str:
    """Return the page. `facts`: command, date, commit, machine, users ..."""
    methods = select.methods(results)
    first = methods[0] if methods else ""
    lead = RECORDED if is_recording(results) else INTRODUCTION
    body = [
        f"<h1>{escape(TITLE)}</h1><p class='lead'>{escape(lead)}</p>",
        _facts(facts),
        _legend(methods),
        _section("", [_table(goal_table(results, note(results)))]),
        *_figures(results, first),
        *(_section(each.title, [_table(each)]) for each in breakdown(results)),
    ]
    style = files(__package__).joinpath("page.css").read_text(encoding="utf-8")
    return (
        "<!doctype html>\n<html lang='en'><head><meta charset='utf-8'>"
        "<meta name='viewport' content='width=device-width, initial-scale=1'>"
        f"<title>{escape(TITLE)}</title><style>\n{style}</style></head>\n"
        f"<body><main>\n{chr(10).join(filter(None, body))}\n</main></body></html>\n"
    )


def _figures(results: Sequence[Result], first: str) -> list[str]:
    return [
        _figure(
            f"Touches around their targets, {first}",
            "Crosses are targets, dots reported touches, ellipses hold 95 % of them. They include "
            "the fingers' own scatter: people do not touch exactly what they aim at.",
            touch_plots.targets(results, first),
        ),
        _figure(
            "Where touches were reported, relative to where they were",
            "The middle is the pad's true place in the frame that reported the touch, or the "
            "target where the truth is unknown. All hits. The ellipse holds 95 %.",
            touch_plots.clouds(results),
        ),
        _figure(
            "F1 by material",
            "Of target pointing. Ghosts, doubled touches and touches outside the target count "
            "against precision.",
            touch_plots.accuracy(results),
        ),
        _figure(
            "Hover, by family of halo curves",
            "Lines are means of all trials, dashed at doubled noise; dots are the single trials of "
            f"{first} at plain noise. On the diagonal, the report is true.",
            level_plots.levels(results, "hover"),
        ),
        _figure(
            "Pressure, by family of halo curves",
            "As above, in grams; the paper's strongest press was 385 g.",
            level_plots.levels(results, "pressure"),
        ),
        _figure(
            "From contact to the frame that reported it",
            "On the frames' own clock, without what receiving, sensing and sending cost. Left of "
            "0: reported before the contact; the median counts it as 0 ms.",
            touch_plots.lateness(results),
        ),
        _figure(
            "Reliability of the confidence",
            "Share of the reported touches that were right, over their confidence; all tasks. On "
            "the diagonal the confidence is what it claims, above it it is too low.",
            touch_plots.reliability_plot(results),
        ),
        _figure(
            "Re-taps reported, by how far the finger rose",
            "The touch point threshold is the least lift from which on 99 % are reported.",
            level_plots.retaps(results),
        ),
    ]


def _figure(title: str, caption: str, drawings: Sequence[str]) -> str:
    if not drawings:
        return ""
    row = f"<div class='row'>{''.join(drawings)}</div>"
    return _section(title, [row, f"<p class='note'>{escape(caption)}</p>"])


def _section(title: str, parts: Iterable[str]) -> str:
    head = f"<h2>{escape(title)}</h2>" if title else ""
    return f"<section>{head}{''.join(parts)}</section>"


def _facts(facts: Mapping[str, str]) -> str:
    rows = "".join(f"<dt>{escape(k)}</dt><dd>{escape(v)}</dd>" for k, v in facts.items())
    return f"<dl>{rows}</dl>" if rows else ""


def _legend(methods: Sequence[str]) -> str:
    chips = (f"<span><i class='m-{escape(name)}'></i>{escape(name)}</span>" for name in methods)
    return f"<p class='legend'>{''.join(chips)}</p>"


def _table(table: Table) -> str:
    head = "".join(f"<th>{escape(cell)}</th>" for cell in table.head)
    rows = "".join(f"<tr>{''.join(map(_cell, row))}</tr>" for row in table.rows)
    note = f"<p class='note'>{escape(table.note)}</p>" if table.note else ""
    return (
        f"<div class='wide'><table><thead><tr>{head}</tr></thead>"
        f"<tbody>{rows}</tbody></table></div>{note}"
    )


def _cell(cell: str) -> str:
    """A verdict becomes a coloured mark, and stays a word."""
    for verdict, kind in ((FAIL, "fail"), (PASS, "pass")):
        if cell.endswith(f", {verdict}"):
            words = _joined(cell.removesuffix(f", {verdict}"))
            return f"<td>{words} <b class='{kind}'>{verdict}</b></td>"
    return f"<td>{_joined(cell)}</td>"


def _joined(words: str) -> str:
    """A number stays on one line with its unit and its deviation."""
    text = escape(words)
    for mark in (" %", " mm", " ms", " ± ", "≤ ", "≥ "):
        text = text.replace(mark, mark.replace(" ", "&nbsp;"))
    return text
