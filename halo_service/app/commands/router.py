"""`halo router`: a Zenoh router between machines and networks."""

from __future__ import annotations

import argparse
from pathlib import Path

from halo_service.app.options import add_debug

SUMMARY = "run a Zenoh router, at which services and clients of several networks meet"
EXAMPLE = "halo router --listen tcp/0.0.0.0:7447"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of the command."""
    add_debug(parser)
    parser.add_argument(
        "file",
        nargs="?",
        type=Path,
        metavar="FILE",
        help="Zenoh configuration (JSON5), for TLS, access control and the like",
    )
    parser.add_argument(
        "--listen",
        action="append",
        metavar="ENDPOINT",
        help="address for services and clients, e.g. tcp/0.0.0.0:7447 (default: those of FILE); "
        "may be repeated",
    )
    parser.add_argument(
        "--connect",
        action="append",
        metavar="ENDPOINT",
        help="another router, or a service; may be repeated",
    )


def run(options: argparse.Namespace) -> int:
    """Run the router until Ctrl-C."""
    from halo_service.app.network.router import RouterSettings, route
    from halo_service.files import from_home

    config = str(from_home(str(options.file))) if options.file else ""
    route(RouterSettings(tuple(options.listen or ()), tuple(options.connect or ()), config))
    return 0
