"""`halo list --watch`: a table that is drawn again and again, or lines for a pipe or a file."""

from __future__ import annotations

import json
import sys
import threading
import time
from collections.abc import Sequence
from contextlib import closing
from typing import TYPE_CHECKING

from halo_client import ZenohSource
from halo_service.app.fleet.node import Node
from halo_service.app.fleet.view import line_of, table_of, value_of, warnings_of
from halo_service.app.fleet.watch import FleetWatch
from halo_service.app.process import stop_on_signals
from halo_service.app.tables import ruled

if TYPE_CHECKING:
    from rich.table import Table as RichTable

DRAW_S = 0.5
LINES_S = 1.0
"""How often lines are compared with the ones before; a node sends its health once a second."""
NARROW = 110
"""Columns of a terminal below which some are left out."""
WAITING = "no node yet; start one with: halo serve"


def watch(sources: Sequence[ZenohSource], *, as_json: bool) -> None:
    """Show all nodes until Ctrl-C or SIGTERM."""
    stopped = threading.Event()
    stop_on_signals(stopped.set)
    with closing(FleetWatch(sources)) as fleet:
        if sys.stdout.isatty() and not as_json:
            _draw(fleet, stopped)
        elif as_json:
            _print_json(fleet, stopped)
        else:
            _print_changes(fleet, stopped)


def _draw(fleet: FleetWatch, stopped: threading.Event) -> None:
    from rich.console import Console, Group
    from rich.live import Live
    from rich.text import Text

    console = Console()

    def picture() -> Group:
        nodes = fleet.nodes()
        here = Text(f"nodes: {len(nodes)}; {time.strftime('%H:%M:%S')}; Ctrl-C ends", "dim")
        warnings = [Text(each, "bold red") for each in warnings_of(nodes)]
        return Group(here, *warnings, "", drawn(nodes) if nodes else Text(WAITING))

    def drawn(nodes: Sequence[Node]) -> RichTable:
        table = ruled(table_of(nodes, narrow=console.width < NARROW))
        table.box, table.pad_edge = None, False
        table.columns[0].no_wrap = True
        return table

    with Live(picture(), console=console, auto_refresh=False, transient=False) as live:
        while not stopped.wait(DRAW_S):
            live.update(picture(), refresh=True)


def _print_json(fleet: FleetWatch, stopped: threading.Event) -> None:
    """Print each node once a second."""
    while not stopped.wait(LINES_S):
        for node in fleet.nodes():
            print(json.dumps(value_of(node)))
        sys.stdout.flush()


def _print_changes(fleet: FleetWatch, stopped: threading.Event) -> None:
    """Print a node when it comes, goes, or has other versions or warnings."""
    before: dict[tuple[str, str, str], tuple[object, ...]] = {}
    while not stopped.wait(LINES_S):
        nodes = fleet.nodes()
        now = {(each.node, each.surface, each.session): _remarkable(each) for each in nodes}
        for each in nodes:
            key = (each.node, each.surface, each.session)
            if before.get(key) != now[key]:
                print(f"{time.strftime('%H:%M:%S')}  {line_of(each)}", flush=True)
        before = now


def _remarkable(node: Node) -> tuple[object, ...]:
    return node.state, node.by, node.versions, node.warnings
