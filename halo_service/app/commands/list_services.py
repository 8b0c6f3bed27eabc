"""`halo list`: every service in reach."""

from __future__ import annotations

import argparse
import json

from halo_service.app.options import add_config, settings_from

SUMMARY = "list every service in reach, found by mDNS and Zenoh"
EXAMPLE = "halo list --json"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of the command."""
    add_config(parser)
    parser.add_argument("--json", action="store_true", help="print one JSON object per service")


def run(options: argparse.Namespace) -> int:
    """Exit code 0: at least one service was found; 1: none."""
    from halo_service.app.discovery import find_services, format_service, table_of
    from halo_service.app.tables import print_tables

    services = find_services(settings_from(options))
    if options.json:
        for service in services:
            print(json.dumps(service._asdict()))
    elif services:
        print_tables(table_of(services), plain="\n".join(map(format_service, services)))
    else:
        print("no service found; start one with: halo serve")
    return 0 if services else 1
