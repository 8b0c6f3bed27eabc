"""`halo install-service`: start the service with the machine."""

from __future__ import annotations

import argparse
import os
import shutil
import sys
from pathlib import Path

from halo_service.app.options import settings_from
from halo_service.errors import UserError

SUMMARY = "start 'halo serve' with the machine, and again whenever it fails"
EXAMPLE = "halo install-service --profile desk"

WAIT_S = "3600"
"""A machine may start before its camera has power."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of the command; every other option is one of `halo serve`."""
    parser.set_defaults(forwards_options=True)
    parser.add_argument("--name", default="halo", help="name of the unit (default: halo)")
    parser.add_argument("--print", action="store_true", help="print the unit, and write nothing")


def run(options: argparse.Namespace) -> int:
    """Write a systemd user unit, or print what to do on Windows."""
    from halo_service.app.install_service import (
        NO_DISPLAY,
        install,
        on_display,
        serve_command,
        unit_path,
        unit_text,
        windows_line,
    )
    from halo_service.app.parser import parse
    from halo_service.app.sources import ANY_CAMERA

    served = parse(["serve", *options.rest])  # leaves with a sentence for a wrong option
    rest = list(options.rest)
    source = settings_from(served).source.name
    if source == "auto":  # it would choose the virtual hand one morning
        rest += ["--source", ANY_CAMERA]
    if served.wait is None:
        rest += ["--wait", WAIT_S]
    command = serve_command(rest)
    if sys.platform == "win32":
        print(windows_line(command, options.name))
        return 0
    variables: dict[str, str] = {}
    if not source.startswith(("sim", "recording:")):
        command, variables = on_display(command, os.environ, shutil.which("xvfb-run"))
        if not variables and command[0] == sys.executable:
            print(NO_DISPLAY, file=sys.stderr)
    text = unit_text(command, Path.cwd(), variables)
    if options.print:
        print(text, end="")
        return 0
    if sys.platform != "linux":
        raise UserError("install-service: it writes systemd units, which only Linux has; --print")
    path = unit_path(options.name)
    install(text, path)
    print(path)
    for line in (
        f"systemctl --user daemon-reload && systemctl --user enable --now {options.name}",
        "loginctl enable-linger   (starts it before anybody logs in)",
        f"journalctl --user -f -u {options.name}   (shows its log)",
    ):
        print(f"next: {line}", file=sys.stderr)
    return 0
