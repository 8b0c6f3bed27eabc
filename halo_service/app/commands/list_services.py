"""`halo list`: every service in reach."""

from __future__ import annotations

import argparse
import json
from dataclasses import replace

from halo_service.app.options import add_config, settings_from

SUMMARY = "list every service in reach, found by mDNS and Zenoh"
EXAMPLE = "halo list --watch --connect tcp/192.168.1.10:7447"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of the command."""
    add_config(parser)
    parser.add_argument(
        "--watch", action="store_true", help="show all nodes and their state until Ctrl-C"
    )
    parser.add_argument(
        "--connect",
        action="append",
        metavar="ENDPOINT",
        help="router or service to ask by Zenoh (default: [zenoh] connect, and with --watch the "
        "service of this machine); may be repeated",
    )
    parser.add_argument(
        "--json",
        action="store_true",
        help="print one JSON object per service; with --watch once a second",
    )


def run(options: argparse.Namespace) -> int:
    """Exit code 0: at least one service was found, or watching was ended; 1: none."""
    from halo_service.app.discovery import find_services, format_service, table_of
    from halo_service.app.tables import print_tables

    settings = settings_from(options)
    if options.watch:
        from halo_service.app.fleet.show import watch
        from halo_service.app.fleet.watch import sources

        watch(sources(settings.zenoh, options.connect or ()), as_json=options.json)
        return 0
    if options.connect:
        zenoh = replace(settings.zenoh, enabled=True, connect=tuple(options.connect))
        settings = replace(settings, zenoh=zenoh)
    services = find_services(settings)
    if options.json:
        for service in services:
            print(json.dumps(service._asdict()))
    elif services:
        print_tables(table_of(services), plain="\n".join(map(format_service, services)))
    else:
        print("no service found; start one with: halo serve")
    return 0 if services else 1
