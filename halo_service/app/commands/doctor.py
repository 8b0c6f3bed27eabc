"""`halo doctor`: find what is missing, and print the remedy."""

from __future__ import annotations

import argparse
import json
import sys
from dataclasses import asdict, replace
from typing import TYPE_CHECKING

from halo_service.app.options import add_profile, add_source, settings_from
from halo_service.errors import UserError

if TYPE_CHECKING:
    from halo_service.app.doctor import Finding, Marks

SUMMARY = "check what is missing on this machine, and print the remedy"
EXAMPLE = "halo doctor --network --connect tcp/192.168.1.5:7447"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of the command."""
    add_profile(parser)
    add_source(parser)
    parser.add_argument(
        "--fix",
        action="store_true",
        help="give every user of this machine access to the cameras (Linux); it shows the file "
        "and asks",
    )
    parser.add_argument(
        "--network",
        action="store_true",
        help="explain what this machine can reach: routers, services, losses, versions, ports",
    )
    parser.add_argument(
        "--connect",
        action="append",
        metavar="ENDPOINT",
        help="with --network: router or service to check, e.g. tcp/192.168.1.5:7447 (default: "
        "[zenoh] connect); may be repeated",
    )
    parser.add_argument("--json", action="store_true", help="print one JSON object per finding")


def run(options: argparse.Namespace) -> int:
    """Exit code 0: nothing that is needed is missing; 1: something is."""
    if options.fix:
        from halo_service.app.cameras.udev import fix

        print(fix(_ask))
        return 0
    if options.connect and not options.network:
        raise UserError("doctor: --connect needs --network")
    from halo_service.app.doctor import NETWORK, PARTS, examine

    settings = settings_from(options)
    if options.network:
        from halo_service.app.network.examine import examine_network

        findings, marks = examine_network(settings, options.connect or ()), NETWORK
    else:
        findings, marks = examine(settings), PARTS
    _show(findings, marks, as_json=options.json)
    if all(finding.good or finding.optional for finding in findings):
        if not options.network:
            print("next: halo serve", file=sys.stderr)
        return 0
    return 1


def _show(findings: list[Finding], marks: Marks, *, as_json: bool) -> None:
    from halo_service.app.doctor import format_finding, table_of
    from halo_service.app.tables import print_tables

    if as_json:
        for finding in findings:
            remedy = "" if finding.good else finding.remedy
            print(json.dumps(asdict(replace(finding, remedy=remedy))))
        return
    plain = "\n".join(format_finding(each, marks) for each in findings)
    print_tables(table_of(findings, marks), plain=plain)


def _ask(question: str) -> bool:
    """Ask on the terminal; without one the answer is no."""
    print(question, end="", flush=True)
    if not sys.stdin.isatty():
        print()
        return False
    return input().strip().lower() in ("y", "yes")
