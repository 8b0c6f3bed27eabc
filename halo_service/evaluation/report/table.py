"""A table of words: as text for a terminal, as Markdown for a page."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import chain
from textwrap import wrap

GAP = "  "
WIDE = 100
"""Columns of a terminal: notes are wrapped to it."""


@dataclass(frozen=True, slots=True)
class Table:
    """Rows under a head; the first column names them."""

    title: str
    head: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    """As many cells each as the head."""
    note: str = ""
    """How to read it."""


def as_text(table: Table) -> str:
    """Return aligned columns."""
    widths = [max(map(len, column)) for column in zip(table.head, *table.rows, strict=True)]
    lines = [_line(row, widths) for row in (table.head, ["-" * width for width in widths])]
    lines += [_line(row, widths) for row in table.rows]
    note = ["", *wrap(table.note, WIDE)] if table.note else []
    return "\n".join([table.title, "", *lines, *note])


def as_markdown(table: Table) -> str:
    """Return a Markdown table under a heading."""
    ruled = chain((table.head, ("---",) * len(table.head)), table.rows)
    lines = ["| " + " | ".join(_escaped(row)) + " |" for row in ruled]
    return "\n".join([f"### {table.title}", "", *lines, *(["", table.note] if table.note else [])])


def _line(row: Sequence[str], widths: Sequence[int]) -> str:
    return GAP.join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)).rstrip()


def _escaped(row: Sequence[str]) -> Iterator[str]:
    return (cell.replace("|", "\\|") for cell in row)
