"""`halo test-pattern`: send a pointer that draws a circle."""

from __future__ import annotations

import argparse

from halo_service.app.options import add_config, seconds, settings_from

SUMMARY = "send a pointer that draws a circle, to check a connection without a camera"
EXAMPLE = "halo test-pattern 192.168.1.20:4256/flat"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of the command."""
    add_config(parser)
    parser.add_argument(
        "destination",
        nargs="*",
        metavar="HOST:PORT",
        help="send OSC here alone, in any format of [osc] destinations (default: on all outputs "
        "of halo.toml)",
    )
    parser.add_argument(
        "--seconds", type=seconds, metavar="S", help="end after this time (default: at Ctrl-C)"
    )


def run(options: argparse.Namespace) -> int:
    """Send until Ctrl-C."""
    from halo_service.app.test_pattern.send import send_pattern
    from halo_service.outputs.destination import parse_destination

    settings = settings_from(options)
    only = [parse_destination(each) for each in options.destination]
    send_pattern(settings, only, options.seconds)
    return 0
