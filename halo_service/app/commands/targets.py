"""`halo targets`: write the sheets to print."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from halo_service.app.options import add_debug
from halo_service.errors import UserError

SUMMARY = "write the sheets to print, surface and anchor, as PDF"
EXAMPLE = "halo targets sheets"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of the command."""
    add_debug(parser)
    parser.add_argument(
        "folder", type=Path, metavar="FOLDER", help="where to write; created if it is missing"
    )


def run(options: argparse.Namespace) -> int:
    """Write the sheets."""
    from halo_calibration.boards.sheets import sheets
    from halo_service.files import appearing

    try:
        options.folder.mkdir(parents=True, exist_ok=True)
        for name, content in sheets().items():
            with appearing(options.folder / name) as file:
                file.write(content)
            print(f"halo: {options.folder / name}", file=sys.stderr)
    except OSError as error:
        raise UserError(
            f"'{options.folder}' cannot be written ({error.strerror or error}); choose another "
            "folder"
        ) from error
    print(
        "next: print them at 100 %, then: halo calibrate surface --by markers --profile desk",
        file=sys.stderr,
    )
    return 0
