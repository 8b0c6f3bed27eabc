"""Whether a display's pixels, as programs see them, are those of the projector.

Rule: a scaled desktop shows programs fewer pixels (Wayland, macOS) or more (X11) than the display
has. On Linux the kernel knows what each display has; on Windows our window asks for real pixels.
"""

from __future__ import annotations

import os
import sys
from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import Path

Size = tuple[int, int]

CONNECTORS = Path("/sys/class/drm")
STATE = "state the projector's own pixels with --size-px WIDTHxHEIGHT"


def doubt_about(
    size_px: Size,
    desktops_px: Sequence[Size],
    platform: str = sys.platform,
    connectors: Path = CONNECTORS,
    environment: Mapping[str, str] = os.environ,
) -> str:
    """Return why a display may be scaled, and the remedy; an empty text if it is not.

    `size_px`: of the display, as programs see it; `desktops_px`: of all displays.
    """
    shown = "{} x {}".format(*size_px)
    if platform == "darwin":
        return (
            f"macOS shows programs {shown} points, which may be fewer than the projector's pixels; "
            f"{STATE}"
        )
    modes = [found for found in map(_modes, sorted(connectors.glob("card*-*"))) if found]
    wayland = "WAYLAND_DISPLAY" in environment or environment.get("XDG_SESSION_TYPE") == "wayland"
    if platform != "linux" or not modes or _is_real(size_px, desktops_px, modes, wayland):
        return ""
    own = ", ".join("{} x {}".format(*each[0]) for each in modes)
    return (
        f"programs see {shown} pixels there, and the connected displays have {own}: the desktop is "
        f"scaled, and other programs would draw beside your fingers; set the scale of each display "
        f"to 100 %, or {STATE}"
    )


def _is_real(
    size_px: Size, desktops_px: Sequence[Size], modes: list[list[Size]], wayland: bool
) -> bool:
    """Compare with the modes of the displays, whose first one is what the display has.

    X11 shows a mode as it is. Wayland may show half of a large mode, which is a smaller mode, too.
    """
    if not wayland:
        return any(_upright(size_px) in map(_upright, each) for each in modes)
    own = Counter(_upright(each[0]) for each in modes)
    return Counter(map(_upright, desktops_px)) <= own


def _upright(size: Size) -> Size:
    """Return a size with the longer side first: a display may be turned."""
    return max(size), min(size)


def _modes(connector: Path) -> list[Size]:
    """Return the modes of a connected display; empty for a connector without one."""
    try:
        if (connector / "status").read_text().strip() != "connected":
            return []
        lines = (connector / "modes").read_text().split()
    except OSError:
        return []
    sizes = (line.rstrip("i").partition("x") for line in lines)
    return [(int(width), int(height)) for width, _, height in sizes if (width + height).isdecimal()]
