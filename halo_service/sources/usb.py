"""Which depth cameras are plugged in, by their USB numbers, where no SDK need be installed.

Rule: reads only. Linux shows each USB device as a folder of `/sys/bus/usb/devices`, with a file for
each fact; other systems show nothing here, and only the SDKs are asked.
"""

from __future__ import annotations

import os
import sys
from dataclasses import dataclass
from pathlib import Path

from halo_service.sources.camera_name import TITLES, CameraKind

MICROSOFT, ORBBEC = 0x045E, 0x2BC5
"""USB vendor numbers."""
CAMERAS: dict[tuple[int, int], tuple[str, CameraKind | None]] = {
    (MICROSOFT, 0x097C): (TITLES["azure-kinect"], "azure-kinect"),
    (ORBBEC, 0x066B): (TITLES["femto-bolt"], "femto-bolt"),
    (ORBBEC, 0x0669): (TITLES["femto-mega"], "femto-mega"),
    (ORBBEC, 0x06C0): ("Femto Mega I", "femto-mega"),
}
"""Vendor and product. The Azure Kinect appears as five devices; 097c is its depth camera (Azure
Kinect documentation, "Azure Kinect DK hardware"). Orbbec's are in its 99-obsensor-libusb.rules."""
USB_3_MBIT = 5000
SYSFS = Path("/sys/bus/usb/devices")
DEVICES = Path("/dev/bus/usb")


@dataclass(frozen=True, slots=True)
class UsbCamera:
    """A depth camera on the USB."""

    title: str
    kind: CameraKind | None
    """None: Orbbec's, of a model that cannot be used here."""
    serial: str
    """Empty where the device does not report it."""
    speed_mbit: int
    node: Path
    """The file through which a program talks to it."""

    @property
    def is_slow(self) -> bool:
        """Whether the port or the cable is not USB 3, which the images need."""
        return self.speed_mbit < USB_3_MBIT

    @property
    def may_open(self) -> bool:
        """Whether this user may talk to it."""
        return os.access(self.node, os.R_OK | os.W_OK)


def usb_cameras(sysfs: Path = SYSFS, devices: Path = DEVICES) -> list[UsbCamera]:
    """List the depth cameras that are plugged in; empty where the system does not show them."""
    if sys.platform != "linux" or not sysfs.is_dir():
        return []
    found = (_camera(folder, devices) for folder in sorted(sysfs.iterdir()))
    return [camera for camera in found if camera is not None]


def _camera(folder: Path, devices: Path) -> UsbCamera | None:
    vendor, product = _number(folder, "idVendor", 16), _number(folder, "idProduct", 16)
    known = CAMERAS.get((vendor, product))
    if known is None and vendor != ORBBEC:
        return None
    title, kind = known or (_text(folder, "product") or f"Orbbec {product:04x}", None)
    bus, number = _number(folder, "busnum", 10), _number(folder, "devnum", 10)
    return UsbCamera(
        title,
        kind,
        _text(folder, "serial"),
        _number(folder, "speed", 10),
        devices / f"{bus:03}" / f"{number:03}",
    )


def _text(folder: Path, name: str) -> str:
    """Read one fact; empty where there is none, or where the device was just unplugged."""
    try:
        text = (folder / name).read_text(encoding="utf-8", errors="replace")
    except OSError:
        return ""
    return "".join(letter for letter in text if letter.isprintable()).strip()


def _number(folder: Path, name: str, base: int) -> int:
    try:
        return int(_text(folder, name), base)
    except ValueError:
        return 0
