"""The permissions of a camera on Linux: a udev rule, shown before it is written.

Rule: only `install` writes a file or runs a command; the text is pure.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

from halo_service.errors import UserError
from halo_service.files import appearing
from halo_service.sources.usb import MICROSOFT, ORBBEC

RULES = Path("/etc/udev/rules.d/99-halo-cameras.rules")
_KINECT_PRODUCTS = ("097a", "097b", "097c", "097d", "097e")
"""Its two hubs, depth, colour and microphones: the SDK opens them all."""
_RELOAD = (["udevadm", "control", "--reload-rules"], ["udevadm", "trigger"])


def rules_text() -> str:
    """Return the rules: every user of this machine may open these cameras."""
    lines = ["# Written by 'halo doctor --fix'. Every user may open an Azure Kinect or a Femto."]
    usb = 'SUBSYSTEM=="usb", ATTR{idVendor}=='
    lines += [
        f'{usb}"{MICROSOFT:04x}", ATTR{{idProduct}}=="{product}", MODE="0666"'
        for product in _KINECT_PRODUCTS
    ]
    lines.append(f'{usb}"{ORBBEC:04x}", MODE="0666"')
    return "\n".join(lines) + "\n"


def fix(ask: Callable[[str], bool], rules: Path = RULES, platform: str = sys.platform) -> str:
    """Show the rules, ask, write them and load them; return what happened.

    Raises `UserError` if they cannot be written.
    """
    if platform != "linux":
        return "permissions: only Linux needs them"
    text = rules_text()
    if rules.is_file() and rules.read_text(encoding="utf-8", errors="replace") == text:
        return f"permissions: {rules} is there already; plug the camera out and in again"
    if not ask(f"This file lets every user open the camera:\n\n{rules}\n{text}\nWrite it? [y/N] "):
        return "permissions: nothing was changed"
    install(text, rules)
    return f"permissions: {rules} is written; plug the camera out and in again"


def install(text: str, rules: Path) -> None:
    """Write the rules and let udev read them. Raises `UserError` if that fails."""
    try:
        with appearing(rules) as file:
            file.write(text.encode())
    except OSError as error:
        command = f"sudo {sys.executable} -m halo_service.app.cli doctor --fix"
        raise UserError(
            f"{rules} cannot be written ({error.strerror}): run it as administrator: {command}"
        ) from error
    if shutil.which("udevadm") and os.access("/run/udev", os.W_OK):
        for command_line in _RELOAD:
            subprocess.run(command_line, check=False, capture_output=True, timeout=10.0)
