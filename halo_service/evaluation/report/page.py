"""One HTML page, complete in itself: no script, no font and no picture from elsewhere."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from html import escape
from importlib.resources import files

from halo_service.evaluation.metrics.result import Result
from halo_service.evaluation.report import level_plots, select, touch_plots
from halo_service.evaluation.report.breakdown import breakdown
from halo_service.evaluation.report.goals import PASS, SHORT, goal_table
from halo_service.evaluation.report.summary import is_recording, note
from halo_service.evaluation.report.table import Table

TITLE = "Touch, hover and pressure, judged"
INTRODUCTION = (
    "The paper's study, played by virtual people under a virtual depth camera, and sensed by every "
    "method from the same frames. What was published is judged against what truly happened. These "
    "figures compare methods; they are no promise about a real table."
)
RECORDED = "One recording, sensed by every method from the same frames."


def page(results: Sequence[Result], facts: Mapping[str, str]) -> str:
    """Return the page; `facts` say what it is of: command, date, machine, users."""
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
            "Crosses are targets, dots touches as they were told, ellipses hold 95 % of them. The "
            "fingers' own scatter is in them: people do not touch exactly what they aim at.",
            touch_plots.targets(results, first),
        ),
        _figure(
            "Where touches were told, from where they were",
            "The middle is the pad's true place in the frame that told the touch, or the target "
            "where nobody knows the truth. Of hits; nothing else is removed. The ellipse holds "
            "95 %.",
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
            f"{first} at plain noise. On the diagonal, what is told is true.",
            level_plots.levels(results, "hover"),
        ),
        _figure(
            "Pressure, by family of halo curves",
            "As above, in grams; the paper's strongest press was 385 g.",
            level_plots.levels(results, "pressure"),
        ),
        _figure(
            "From contact to the frame that told it",
            "On the frames' own clock, without what receiving, sensing and sending cost. Left of 0 "
            "lies what was told before its contact; the median counts it as told at once.",
            touch_plots.lateness(results),
        ),
        _figure(
            "Re-taps told, by how far the finger rose",
            "The touch point threshold is the least lift from which on 99 % are told.",
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
    """A verdict becomes a mark that is seen from afar, and stays a word."""
    for verdict, kind in ((SHORT, "short"), (PASS, "pass")):
        if cell.endswith(f", {verdict}"):
            told = _joined(cell.removesuffix(f", {verdict}"))
            return f"<td>{told} <b class='{kind}'>{verdict}</b></td>"
    return f"<td>{_joined(cell)}</td>"


def _joined(words: str) -> str:
    """A number stays on one line with its unit and with what it is off by."""
    told = escape(words)
    for mark in (" %", " mm", " ms", " ± ", "≤ ", "≥ "):
        told = told.replace(mark, mark.replace(" ", "&nbsp;"))
    return told
