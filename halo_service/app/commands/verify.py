"""`halo verify`: touch a projected grid, and measure the error."""

from __future__ import annotations

import argparse

from halo_service.app.options import add_profile, add_screen, add_source, settings_from

SUMMARY = "touch a projected grid and measure how far off the touches are"
EXAMPLE = "halo verify --profile desk --display 1"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of the command."""
    add_profile(parser)
    add_source(parser)
    parser.add_argument(
        "--from",
        dest="service",
        nargs="?",
        const="osc://127.0.0.1:4256",
        metavar="URL",
        help="use the touches of a running service, not a source "
        "(without URL: osc://127.0.0.1:4256)",
    )
    add_screen(parser)
    parser.add_argument(
        "--within-mm", type=float, default=5.0, metavar="MM", help="bound for 95 %% of the touches"
    )


def run(options: argparse.Namespace) -> int:
    """Exit code 0: all crossings were touched within the bound; 1: they were not."""
    from halo_service.app.projector.screens import ScreenRequest
    from halo_service.app.verification.verify import VerifyRequest, verify

    screen = ScreenRequest(options.display, options.window)
    request = VerifyRequest(screen, options.service, options.within_mm)
    return verify(settings_from(options), request)
