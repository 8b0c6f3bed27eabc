"""`halo canvas`: serve surfaces of several nodes as one, and find where they are."""

from __future__ import annotations

import argparse
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from halo_service.app.options import (
    add_config,
    add_connect,
    add_outputs,
    seconds,
    settings_from,
    with_outputs,
    zenoh_source,
)
from halo_service.errors import UserError

if TYPE_CHECKING:
    from halo_client import Follow
    from halo_service.settings import Settings

SUMMARY = "merge the surfaces of several services into one, find where they are, or draw it"
EXAMPLE = "halo canvas serve table.toml --connect tcp/192.168.1.10:7447"
NODE_END = "-canvas"
LEAST_TOUCHES = 3


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
    find = actions.add_parser(
        "find", help="write a layout file from touches that two cameras see, or from a marker"
    )
    find.add_argument(
        "--node",
        action="append",
        metavar="NAME",
        help="service, or one surface of it as NAME/SURFACE (default: table); two or more",
    )
    find.add_argument(
        "--by", choices=("touch", "marker"), default="touch", help="touch (default) or marker"
    )
    find.add_argument("--touches", type=int, default=6, metavar="N", help="default: 6, least: 3")
    find.add_argument(
        "--seconds", type=seconds, default=180.0, metavar="S", help="time for them (default: 180)"
    )
    find.add_argument("--out", type=Path, metavar="LAYOUT.toml", help="default: stdout")
    find.add_argument("--force", action="store_true", help="replace a file of that name")
    add_connect(find, "all of them are used")
    add_config(find)
    draw = actions.add_parser("draw", help="draw what nodes and canvas report for some seconds")
    draw.add_argument("layout", type=Path, metavar="LAYOUT.toml")
    draw.add_argument("--out", type=Path, required=True, metavar="X.png")
    draw.add_argument(
        "--seconds", type=seconds, default=10.0, metavar="S", help="how long (default: 10)"
    )
    add_connect(draw, "all of them are used")
    add_config(draw)


def run(options: argparse.Namespace) -> int:
    """Run the action."""
    return {"serve": _serve, "find": _find, "draw": _draw}[options.action](options)


def _serve(options: argparse.Namespace) -> int:
    """Serve until Ctrl-C."""
    settings = with_outputs(settings_from(options), options)
    from halo_service.canvas.layout import load

    layout = load(options.layout)
    from halo_service.app.canvas.run import serve_canvas

    source = zenoh_source(settings, options.connect)
    serve_canvas(_canvas_settings(settings, options, source.connect), layout, source)
    return 0


def _find(options: argparse.Namespace) -> int:
    """Write a layout file."""
    settings = settings_from(options)
    follows = _follows(options.node or [])
    if options.touches < LEAST_TOUCHES:
        raise UserError(f"canvas: --touches must be {LEAST_TOUCHES} or more, not {options.touches}")
    from halo_service.app.files import STDOUT, refuse_existing, written

    if options.out is not None:
        refuse_existing(options.out, force=options.force)
    from halo_service.app.canvas.find import find
    from halo_service.canvas.layout import text

    source = zenoh_source(settings, options.connect)
    layout = find(follows, source, options.by, options.touches, options.seconds)
    with written(STDOUT if options.out is None else str(options.out)) as file:
        file.write(text(layout))
    if options.out is not None:
        import sys

        connect = "".join(f" --connect {each}" for each in options.connect or ())
        print(f"next: halo canvas serve {options.out}{connect}", file=sys.stderr)
    return 0


def _draw(options: argparse.Namespace) -> int:
    """Write a picture."""
    settings = settings_from(options)
    from halo_service.canvas.layout import load

    layout = load(options.layout)
    from halo_service.app.canvas.draw import draw

    draw(layout, zenoh_source(settings, options.connect), options.seconds, options.out)
    print(options.out)
    return 0


def _follows(names: list[str]) -> list[Follow]:
    """Read `--node`. Raises `UserError`."""
    import halo_protocol as wire
    from halo_client import Follow

    follows = []
    for name in names:
        node, _, surface = name.partition("/")
        try:
            wire.check_name(node, "node")
            follows.append(Follow(node, wire.check_surface(surface or wire.DEFAULT_SURFACE)))
        except wire.ProtocolError as error:
            raise UserError(f"canvas: {error}; write --node NAME or NAME/SURFACE") from error
    if len(set(follows)) < 2 or len(set(follows)) < len(follows):
        raise UserError("canvas: name two or more different services, each with --node")
    return follows


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
