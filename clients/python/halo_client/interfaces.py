"""Which network interface Zenoh's multicast uses."""

from __future__ import annotations

from pathlib import Path

LINUX = Path("/sys/class/net")
_UP, _LOOPBACK = 0x1, 0x8
"""Flags of an interface, as in Linux' `if.h`."""


def multicast_interface(folder: Path = LINUX) -> str:
    """Return `auto`, or the loopback where no other interface is up, as in a container.

    Zenoh's `auto` leaves the loopback out, so that it would find nothing there.
    """
    flags = {each.parent.name: _flags(each) for each in folder.glob("*/flags")}
    up = {name: bits for name, bits in flags.items() if bits & _UP}
    others = [name for name, bits in up.items() if not bits & _LOOPBACK]
    return "auto" if others or not up else next(iter(up))


def _flags(path: Path) -> int:
    try:
        return int(path.read_text(), 16)
    except (OSError, ValueError):  # it was removed meanwhile
        return 0
