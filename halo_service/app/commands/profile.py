"""`halo profile`: list, show, copy, rename, delete, export and import profiles."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from halo_service.app.options import add_debug

SUMMARY = "list, show, copy, rename, delete, export or import profiles"
EXAMPLE = "halo profile export desk desk.halo-profile"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of the command."""
    add_debug(parser)
    actions = parser.add_subparsers(dest="action", required=True, metavar="ACTION", title="actions")
    actions.add_parser("list", help="list the profiles in your data folder")
    actions.add_parser("show", help="show one profile").add_argument("name", metavar="NAME")
    copy = actions.add_parser("copy", help="copy a profile to another name")
    copy.add_argument("name", metavar="NAME")
    copy.add_argument("to", metavar="NEW_NAME")
    rename = actions.add_parser("rename", help="give a profile another name")
    rename.add_argument("name", metavar="NAME")
    rename.add_argument("to", metavar="NEW_NAME")
    actions.add_parser("delete", help="remove a profile").add_argument("name", metavar="NAME")
    export = actions.add_parser("export", help="write a profile to one file")
    export.add_argument("name", metavar="NAME")
    export.add_argument("out", type=Path, metavar="FILE")
    export.add_argument("--force", action="store_true", help="replace a file of that name")
    importing = actions.add_parser("import", help="read a profile from such a file")
    importing.add_argument("file", type=Path, metavar="FILE")
    importing.add_argument("--name", help="name to import it as (default: its own)")


def run(options: argparse.Namespace) -> int:
    """Run the action; a path that was written goes to stdout."""
    from halo_service.app import profiles

    if options.action == "list":
        profiles.print_list()
    elif options.action == "show":
        profiles.print_profile(options.name)
    elif options.action == "copy":
        _written(profiles.copy(options.name, options.to))
    elif options.action == "rename":
        _written(profiles.rename(options.name, options.to))
    elif options.action == "delete":
        print(f"removed {profiles.delete(options.name)}", file=sys.stderr)
    elif options.action == "export":
        profiles.export(options.name, options.out, options.force)
        print(options.out)
    else:
        _written(profiles.import_profile(options.file, options.name))
    return 0


def _written(folder: Path) -> None:
    print(folder)
    print(f"next: halo serve --profile {folder.name}", file=sys.stderr)
