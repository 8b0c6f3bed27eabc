"""`halo replay`: sense a recording into a file."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from halo_service.app.options import add_profile, settings_from

SUMMARY = "sense a recording and write the result as JSON lines"
EXAMPLE = "halo replay recording.mkv --profile desk --jsonl recording.jsonl"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of the command."""
    add_profile(parser)
    parser.add_argument(
        "recording", type=Path, metavar="RECORDING", help="a recording of 'halo record'"
    )
    parser.add_argument("--jsonl", required=True, metavar="OUT", help="file to write; - for stdout")
    parser.add_argument(
        "--method", default="ours", metavar="M", help="ours (default), paper, direct or wilson"
    )


def run(options: argparse.Namespace) -> int:
    """Replay the recording."""
    from halo_service.app.files import STDOUT
    from halo_service.app.recordings.replay import replay

    settings = settings_from(options)
    count = replay(options.recording, options.jsonl, settings, options.method)
    print(f"halo: {count} frames", file=sys.stderr)
    if not settings.profile:
        print("halo: no profile: the frames have no touches; add --profile P", file=sys.stderr)
    if options.jsonl != STDOUT:
        print(f"next: halo monitor --from {options.jsonl}", file=sys.stderr)
    return 0
