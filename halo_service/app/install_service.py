"""Makes `halo serve` start with the machine: a systemd user unit, or a line for Windows.

Rule: only `install` writes a file; the texts are pure.
"""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path

from halo_service.errors import UserError
from halo_service.files import appearing

MARK = "# Written by 'halo install-service'; run it again to change this file."
"""First line of a unit that may be replaced."""
DISPLAY_VARIABLES = ("DISPLAY", "XAUTHORITY")
WATCHDOG_S = 30
"""A live loop that does not report for so long is started again."""
UNIT = """\
{mark}
[Unit]
Description=halo-service: touch, hover and pressure from a depth camera
StartLimitIntervalSec=0

[Service]
Type=notify
NotifyAccess={access}
{variables}ExecStart={command}
WorkingDirectory={folder}
WatchdogSec={watchdog_s}
Restart=always
RestartSec=2
TimeoutStartSec=infinity
TimeoutStopSec=15

[Install]
WantedBy=default.target
"""
"""It starts as often as needed, and as long as the first start takes: that downloads the hand
model and waits for the camera."""


def serve_command(options: Sequence[str]) -> list[str]:
    """Return the command that runs the service with these options, from any folder."""
    return [sys.executable, "-m", "halo_service.app.cli", "serve", *options]


NO_DISPLAY = (
    "note: there is no display here, which the depth engine of an Azure Kinect or a Femto Bolt "
    "needs: run this again on the machine's screen, or after 'apt install xvfb'"
)


def on_display(
    command: Sequence[str], environment: Mapping[str, str], xvfb_run: str | None
) -> tuple[list[str], dict[str, str]]:
    """Return the command with a display, and the variables that it needs.

    The depth engine needs a display: the one of this session, else a virtual one (`xvfb_run`: the
    program that starts it, where it is installed).
    """
    variables = {name: environment[name] for name in DISPLAY_VARIABLES if environment.get(name)}
    if "DISPLAY" in variables:
        return list(command), variables
    return [*([xvfb_run, "-a"] if xvfb_run else []), *command], {}


def unit_text(
    command: Sequence[str], folder: Path, variables: Mapping[str, str] | None = None
) -> str:
    """Return a systemd unit. `variables`: of the environment."""
    set_here = [_quoted(f"{name}={value}") for name, value in (variables or {}).items()]
    return UNIT.format(
        mark=MARK,
        access="main" if command[0] == sys.executable else "all",  # a wrapper is the main process
        variables="".join(f"Environment={each}\n" for each in set_here),
        command=" ".join(map(_quoted, command)),
        folder=str(folder).replace("%", "%%"),
        watchdog_s=WATCHDOG_S,
    )


def windows_line(command: Sequence[str], name: str) -> str:
    """Return the line for a command prompt that adds the service to the Task Scheduler."""
    inner = subprocess.list2cmdline(command).replace('"', '\\"')
    return f'schtasks /Create /F /SC ONLOGON /TN {name} /TR "{inner}"'


def unit_path(name: str) -> Path:
    """Return where systemd reads a user's unit. Raises `UserError` for a user without a home."""
    base = os.environ.get("XDG_CONFIG_HOME") or os.path.expanduser("~/.config")  # noqa: PTH111
    if not os.path.isabs(base):  # noqa: PTH117 - of a text that may be relative
        raise UserError(
            "install-service: this user has no home folder; set HOME or XDG_CONFIG_HOME"
        )
    return Path(base) / "systemd" / "user" / f"{name}.service"


def install(text: str, path: Path) -> None:
    """Write a unit. Raises `UserError` for a file that somebody else wrote, or none can write."""
    try:
        if path.exists() and not path.read_text(encoding="utf-8", errors="replace").startswith(
            MARK
        ):
            raise UserError(f"{path} was not written by halo; choose another --name, or remove it")
        path.parent.mkdir(parents=True, exist_ok=True)
        with appearing(path) as file:
            file.write(text.encode())
    except OSError as error:
        raise UserError(f"{path} cannot be written ({error.strerror})") from error


def _quoted(word: str) -> str:
    """Quote a word for ExecStart: systemd expands % and $ and reads backslashes."""
    escaped = word.replace("\\", "\\\\").replace('"', '\\"').replace("%", "%%").replace("$", "$$")
    return escaped if word and not set(word) & set(" \t\"'\\;") else f'"{escaped}"'
