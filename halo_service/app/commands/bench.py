"""`halo bench`: measure the latency on this machine."""

from __future__ import annotations

import argparse

from halo_service.app.options import add_profile, add_source, settings_from

SUMMARY = "measure how soon touches leave this machine"
EXAMPLE = "halo bench --hands 1 --seconds 10"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of the command."""
    add_profile(parser)
    parser.add_argument(
        "--hands", type=int, choices=(1, 2), help="number of hands (default: one, then two)"
    )
    parser.add_argument(
        "--seconds",
        type=float,
        default=15.0,
        metavar="N",
        help="length of a recording (default 15)",
    )
    add_source(parser, "recording:FILE or sim[:SCENARIO]")
    parser.add_argument("--json", metavar="FILE", help="write all figures; - for stdout")


def run(options: argparse.Namespace) -> int:
    """Measure and print."""
    from halo_service.app.benchmarking.bench import BenchRequest, bench

    settings = settings_from(options)
    # A real table's profile does not fit the virtual room, which is calibrated by itself.
    profile = options.profile or (settings.profile if options.source else "")
    request = BenchRequest(options.hands, options.seconds, options.source, profile, options.json)
    bench(request, settings)
    return 0
