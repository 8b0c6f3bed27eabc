"""`halo doctor`: find what is missing, and print the remedy."""

from __future__ import annotations

import argparse

from halo_service.app.options import add_profile, add_source, settings_from

SUMMARY = "check what is missing on this machine, and print the remedy"
EXAMPLE = "halo doctor --profile desk"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of the command."""
    add_profile(parser)
    add_source(parser)


def run(options: argparse.Namespace) -> int:
    """Exit code 0: nothing is missing; 1: something is."""
    from halo_service.app.doctor import examine, told

    findings = examine(settings_from(options))
    print("\n".join(told(finding) for finding in findings))
    return int(not all(finding.good for finding in findings))
