"""`halo bridge`: serve nodes of Zenoh on another machine."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

from halo_service.app.options import (
    add_config,
    add_connect,
    add_outputs,
    settings_from,
    with_outputs,
    zenoh_source,
)
from halo_service.errors import UserError

if TYPE_CHECKING:
    from halo_client import Follow

SUMMARY = "serve the touches of another machine, from Zenoh, as local OSC, TUIO and WebSocket"
EXAMPLE = "halo bridge --connect tcp/192.168.1.10:7447 --osc 127.0.0.1:7000/flat"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of the command."""
    add_config(parser)
    add_connect(parser, "the first that answers is used")
    parser.add_argument(
        "--node",
        action="append",
        metavar="NAME",
        help="service to follow, or one surface of it as NAME/SURFACE (default: the first that "
        "sends); may be repeated, then its surfaces are called NAME-SURFACE",
    )
    add_outputs(parser)


def run(options: argparse.Namespace) -> int:
    """Run the bridge until Ctrl-C."""
    settings = with_outputs(settings_from(options), options)
    follows = _follows(options.node or [])
    from halo_service.app.bridge.run import bridge

    # A router passes nothing from one peer to another, so the bridge is its client.
    bridge(settings, follows, zenoh_source(settings, options.connect, "client"))
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
            if surface:
                wire.check_surface(surface)
            if len(names) > 1:
                wire.check_surface(f"{node}-{surface or wire.DEFAULT_SURFACE}")
        except wire.ProtocolError as error:
            raise UserError(
                f"bridge: {error}; write --node NAME or NAME/SURFACE; with several nodes "
                "NAME-SURFACE has at most 32 characters"
            ) from error
        follows.append(Follow(node, surface or wire.ANY))
    if len(set(follows)) < len(follows):
        raise UserError("bridge: a node is named twice; name each --node once")
    return follows or [Follow()]
