"""The command line options of all clients with a window."""

from __future__ import annotations

import argparse

import halo_client


def add_source_option(parser: argparse.ArgumentParser) -> None:
    """`--from`."""
    parser.add_argument(
        "--from",
        dest="source",
        default=halo_client.DEFAULT_SOURCE,
        metavar="SOURCE",
        help="where frames come from: osc://127.0.0.1:4256 (default), "
        "'osc://?hello=127.0.0.1:4257' (while another client runs), "
        "zenoh://?connect=tcp/127.0.0.1:7447, or FILE.jsonl",
    )


def add_stage_options(parser: argparse.ArgumentParser) -> None:
    """`--from`, `--full-screen`, `--display`."""
    add_source_option(parser)
    parser.add_argument(
        "--full-screen",
        action="store_true",
        help="fill the display; on a calibrated projector, things appear under your fingers",
    )
    parser.add_argument(
        "--display",
        type=int,
        default=0,
        metavar="N",
        help="which display, from 0; the projector is often 1",
    )
