"""`halo serve`: run the service."""

from __future__ import annotations

import argparse
from dataclasses import replace

from halo_service.app.options import (
    add_outputs,
    add_profile,
    add_source,
    found_at,
    seconds,
    settings_from,
    with_outputs,
)

SUMMARY = "run the service: read a camera, send touches"
EXAMPLE = "halo serve --profile desk --osc 192.168.1.20:4256"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of the command."""
    add_profile(parser)
    add_source(parser)
    parser.add_argument("--loop", action="store_true", help="start a recording again at its end")
    parser.add_argument("--fast", action="store_true", help="read a recording as fast as possible")
    parser.add_argument(
        "--wait",
        type=seconds,
        metavar="S",
        help="longest wait for a camera at the start (default: 0)",
    )
    parser.add_argument("--log-json", action="store_true", help="a JSON object for each log line")
    parser.add_argument("--node", metavar="NAME", help="name of this service on the network")
    add_outputs(parser)
    parser.add_argument(
        "--zenoh-listen", action="append", metavar="ENDPOINT", help="e.g. tcp/127.0.0.1:7447"
    )
    parser.add_argument(
        "--zenoh-connect", action="append", metavar="ENDPOINT", help="router or peer to connect to"
    )
    parser.add_argument("--no-zenoh", action="store_true", help="open no Zenoh session")
    parser.add_argument("--no-page", action="store_true", help="serve no control page")
    parser.add_argument("--open", action="store_true", help="open the control page in a browser")


def run(options: argparse.Namespace) -> int:
    """Run the service; the command line wins over the settings file."""
    settings = with_outputs(settings_from(options), options)
    source = replace(
        settings.source,
        loop=options.loop or settings.source.loop,
        fast=options.fast or settings.source.fast,
        wait_s=settings.source.wait_s if options.wait is None else options.wait,
    )
    zenoh = replace(
        settings.zenoh,
        enabled=settings.zenoh.enabled and not options.no_zenoh,
        listen=tuple(options.zenoh_listen or settings.zenoh.listen),
        connect=tuple(options.zenoh_connect or settings.zenoh.connect),
    )
    page = replace(settings.page, enabled=settings.page.enabled and not options.no_page)
    from halo_service.app.page.parts import PageRequest
    from halo_service.app.service.serve import serve  # heavy: settings are checked before

    serve(
        replace(
            settings,
            node=options.node or settings.node,
            source=source,
            zenoh=zenoh,
            page=page,
        ),
        found_at(options.config),
        PageRequest(options.config, options.open),
    )
    return 0
