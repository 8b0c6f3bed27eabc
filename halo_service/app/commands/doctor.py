"""`halo doctor`: find what is missing, and print the remedy."""

from __future__ import annotations

import argparse
import sys

from halo_service.app.options import add_profile, add_source, settings_from

SUMMARY = "check what is missing on this machine, and print the remedy"
EXAMPLE = "halo doctor --profile desk"


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


def run(options: argparse.Namespace) -> int:
    """Exit code 0: nothing that is needed is missing; 1: something is."""
    if options.fix:
        from halo_service.app.cameras.udev import fix

        print(fix(_ask))
        return 0
    from halo_service.app.doctor import examine, format_finding, table_of
    from halo_service.app.tables import print_tables

    findings = examine(settings_from(options))
    print_tables(table_of(findings), plain="\n".join(map(format_finding, findings)))
    if all(finding.good or finding.optional for finding in findings):
        print("next: halo serve", file=sys.stderr)
        return 0
    return 1


def _ask(question: str) -> bool:
    """Ask on the terminal; without one the answer is no."""
    print(question, end="", flush=True)
    if not sys.stdin.isatty():
        print()
        return False
    return input().strip().lower() in ("y", "yes")
