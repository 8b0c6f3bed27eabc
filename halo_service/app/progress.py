"""A progress bar on stderr; where stderr is no terminal, none is drawn."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rich.progress import Progress, TaskID


class Bar:
    """One bar that may be hidden."""

    def __init__(self, drawn: tuple[Progress, TaskID] | None) -> None:
        """`drawn`: what is drawn; None: nothing is."""
        self._drawn = drawn

    def advance(self, amount: float = 1.0) -> None:
        """Add to what is done."""
        if self._drawn is not None:
            progress, task = self._drawn
            progress.advance(task, amount)

    def say(self, text: str) -> None:
        """Print a line on stderr, above the bar."""
        if self._drawn is None:
            print(text, file=sys.stderr)
        else:
            self._drawn[0].console.print(text, markup=False, highlight=False)


@contextmanager
def progress(what: str, total: float | None = None) -> Iterator[Bar]:
    """Draw a bar while the block runs, and remove it then.

    `total`: what `advance` sums up to; None: unknown, so the bar counts frames.
    """
    if not sys.stderr.isatty():
        yield Bar(None)
        return
    from rich.console import Console
    from rich.progress import (
        BarColumn,
        Progress,
        TaskProgressColumn,
        TextColumn,
        TimeElapsedColumn,
        TimeRemainingColumn,
    )

    counted = TextColumn("{task.completed:.0f} frames") if total is None else TaskProgressColumn()
    columns = (TextColumn("{task.description}", markup=False), BarColumn(), counted)
    times = (TimeElapsedColumn(), TextColumn("left:"), TimeRemainingColumn())
    with Progress(
        *columns,
        *(times if total is not None else times[:1]),
        console=Console(stderr=True),
        transient=True,
        redirect_stdout=False,  # stdout may be a file of figures
    ) as drawn:
        yield Bar((drawn, drawn.add_task(what, total=total)))
