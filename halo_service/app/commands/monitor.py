"""`halo monitor`: show what a service sends; the client's own command."""

from __future__ import annotations

import argparse

from halo_tools import monitor

SUMMARY = "show what a running service sends"
EXAMPLE = "halo monitor --from osc://127.0.0.1:4256"

add_arguments = monitor.add_arguments


def run(options: argparse.Namespace) -> int:
    """Show it until Ctrl-C."""
    return monitor.run(options)
