"""`halo canvas`: serve surfaces of several nodes as one."""

from __future__ import annotations

import argparse
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from halo_service.app.options import (
    add_config,
    add_connect,
    add_outputs,
    settings_from,
    with_outputs,
    zenoh_source,
)

if TYPE_CHECKING:
    from halo_service.settings import Settings

SUMMARY = "merge the surfaces of several services into one"
EXAMPLE = "halo canvas serve table.toml --connect tcp/192.168.1.10:7447"
NODE_END = "-canvas"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of the command."""
    actions = parser.add_subparsers(dest="action", required=True, metavar="ACTION", title="actions")
    serve = actions.add_parser("serve", help="serve the canvas of a layout file")
    serve.add_argument("layout", type=Path, metavar="LAYOUT.toml")
    serve.add_argument(
        "--node", metavar="NAME", help="name of the canvas on the network (default: MACHINE-canvas)"
    )
    add_connect(serve, "all of them are used")
    add_outputs(serve)
    serve.add_argument(
        "--zenoh-listen", action="append", metavar="ENDPOINT", help="e.g. tcp/127.0.0.1:7448"
    )
    serve.add_argument("--no-zenoh", action="store_true", help="send nothing by Zenoh")
    add_config(serve)


def run(options: argparse.Namespace) -> int:
    """Run the action."""
    return _serve(options)


def _serve(options: argparse.Namespace) -> int:
    """Serve until Ctrl-C."""
    settings = with_outputs(settings_from(options), options)
    from halo_service.canvas.layout import load

    layout = load(options.layout)
    from halo_service.app.canvas.run import serve_canvas

    source = zenoh_source(settings, options.connect)
    serve_canvas(_canvas_settings(settings, options, source.connect), layout, source)
    return 0


def _canvas_settings(
    settings: Settings, options: argparse.Namespace, connect: tuple[str, ...]
) -> Settings:
    """Return the settings of the canvas's own outputs.

    It connects to where its nodes are, so that clients of the same router receive it, too.
    """
    zenoh = replace(
        settings.zenoh,
        enabled=settings.zenoh.enabled and not options.no_zenoh,
        connect=connect,
        listen=tuple(options.zenoh_listen or settings.zenoh.listen),
    )
    node = options.node or f"{settings.node[: 32 - len(NODE_END)]}{NODE_END}"
    return replace(settings, node=node, zenoh=zenoh)
