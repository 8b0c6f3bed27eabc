"""`halo cameras`: what is plugged in."""

from __future__ import annotations

import argparse
import json

from halo_service.app.options import add_debug

SUMMARY = "list the depth cameras that are plugged in, and what each lacks"
EXAMPLE = "halo cameras --json"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of the command."""
    add_debug(parser)
    parser.add_argument("--json", action="store_true", help="print one JSON object per camera")


def run(options: argparse.Namespace) -> int:
    """Exit code 0: at least one camera can be opened, as far as one can see; 1: none."""
    from halo_service.app.cameras.found import found_cameras, table_of
    from halo_service.app.tables import print_tables

    cameras = found_cameras()
    if options.json:
        for camera in cameras:
            print(json.dumps(camera.as_dict()))
    elif cameras:
        print_tables(table_of(cameras), plain="\n".join(map(str, cameras)))
    else:
        print("no camera found; plug one in, or use the virtual one with: halo serve --source sim")
    return 0 if any(camera.source and not camera.fault for camera in cameras) else 1
