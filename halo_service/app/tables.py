"""A table on stdout: ruled and coloured on a terminal, plain lines for a pipe or a file."""

from __future__ import annotations

import sys
from typing import TYPE_CHECKING

from halo_service.evaluation.report.table import Table, as_text

if TYPE_CHECKING:
    from rich.table import Table as RichTable

STYLES = {"MISSING": "bold red", "fail": "bold red", "ok": "green", "pass": "green"}
"""Colours of cells with exactly this word."""


def print_tables(*tables: Table, plain: str | None = None) -> None:
    """Print tables, one below the other.

    `plain`: what to print if stdout is no terminal, for programs that read it; None: aligned
    columns.
    """
    if sys.stdout.isatty():
        from rich.console import Console

        Console(file=sys.stdout).print(*map(ruled, tables), sep="\n")
    else:
        print("\n\n".join(map(as_text, tables)) if plain is None else plain, flush=True)


def ruled(table: Table) -> RichTable:
    """Return a table as a terminal shows it."""
    from rich import box
    from rich.table import Table as RichTable
    from rich.text import Text

    drawn = RichTable(
        title=Text(table.title) if table.title else None,
        title_justify="left",
        title_style="bold",
        caption=Text(table.note) if table.note else None,
        caption_justify="left",
        box=box.SIMPLE_HEAD,
        show_header=any(table.head),
    )
    for name in table.head:
        # Fold: a path that is cut off would be useless.
        drawn.add_column(Text(name), overflow="fold")
    for row in table.rows:
        drawn.add_row(*(Text(cell, STYLES.get(cell, "")) for cell in row))
    return drawn
