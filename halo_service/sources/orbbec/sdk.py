"""Loads Orbbec's SDK without its noise, and lists the cameras that it sees.

Rule: `pyorbbecsdk` is imported only here, and only when a camera is looked for.
"""

from __future__ import annotations

import os
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from types import ModuleType
from typing import Any

from halo_service.errors import UserError
from halo_service.sources.camera_name import CameraKind

EXTRA = "uv sync --extra orbbec"
"""Installs the SDK."""
PRODUCTS: dict[int, CameraKind] = {
    0x066B: "femto-bolt",
    0x0669: "femto-mega",
    0x06C0: "femto-mega",  # Femto Mega I, its case for industry
}
"""USB product numbers of the cameras that have the sensor (OrbbecSDK_v2, DevicePids.hpp)."""
_PORT = 8090
"""Of a Femto Mega in the network: the SDK's default."""
_CONFIG = """\
<?xml version="1.0" encoding="UTF-8"?>
<Config>
    <ConfigStandardVersion>1.1</ConfigStandardVersion>
    <Device><EnumerateNetDevice>false</EnumerateNetDevice></Device>
</Config>
"""
"""By default the SDK asks the network for cameras, which takes a second each time."""


@dataclass(frozen=True, slots=True)
class Plugged:
    """A camera of Orbbec that the SDK sees."""

    name: str
    kind: CameraKind | None
    """None: a model without the sensor, e.g. a stereo camera."""
    serial: str
    connection: str
    """E.g. `USB3.1`."""


class Sdk:
    """The loaded SDK and its context; one for a process."""

    def __init__(self, module: Any, context: Any) -> None:
        """`module`: `pyorbbecsdk`; `context`: its `Context`."""
        self.module = module
        self._context = context

    def plugged(self) -> list[Plugged]:
        """List the cameras that are plugged in, of every model."""
        devices = self._context.query_devices()
        return [
            Plugged(
                devices.get_device_name_by_index(number),
                PRODUCTS.get(devices.get_device_pid_by_index(number)),
                devices.get_device_serial_number_by_index(number),
                devices.get_device_connection_type_by_index(number),
            )
            for number in range(devices.get_count())
        ]

    def device(self, serial: str) -> Any:
        """Open the device with this serial number. Raises the SDK's `OBError`."""
        return self._context.query_devices().get_device_by_serial_number(serial)

    def network_device(self, address: str) -> Any:
        """Open a camera in the network. Raises the SDK's `OBError`."""
        return self._context.create_net_device(address, _PORT)


@cache
def load() -> Sdk:
    """Load the SDK. Raises `UserError` if it is not installed or cannot be loaded."""
    module = _module()
    log = module.OBLogLevel
    folder = Path(tempfile.gettempdir()) / f"halo-orbbec-{os.getuid() if _POSIX else 0}"
    try:
        folder.mkdir(mode=0o700, exist_ok=True)
        config = folder / "config.xml"
        config.write_text(_CONFIG)
    except OSError as error:
        raise UserError(
            f"{folder} cannot be written ({error.strerror}), where the SDK of Orbbec logs; "
            "free some space or set TMPDIR"
        ) from error
    # Otherwise it logs among our output, and to a folder 'Log' of the folder it is started in.
    module.Context.set_logger_to_console(log.NONE)
    module.Context.set_logger_to_file(log.INFO, str(folder))
    return Sdk(module, module.Context(str(config)))


def plugged() -> list[Plugged]:
    """List the cameras that the SDK sees; none without the SDK."""
    try:
        return load().plugged()
    except UserError:
        return []


_POSIX = sys.platform != "win32"


def _module() -> ModuleType:
    try:
        with _silent_stdout():
            import pyorbbecsdk
    except (ImportError, OSError) as error:
        raise UserError(
            "the software of Orbbec's cameras (pyorbbecsdk2) is not installed or cannot be loaded "
            f"({error}): {EXTRA}"
        ) from error
    module: ModuleType = pyorbbecsdk
    return module


@contextmanager
def _silent_stdout() -> Iterator[None]:
    """Silence what C++ prints on stdout, where our own output goes."""
    try:
        before = os.dup(1)
    except OSError:  # there is no stdout
        yield
        return
    sys.stdout.flush()
    nothing = os.open(os.devnull, os.O_WRONLY)
    try:
        os.dup2(nothing, 1)
        yield
    finally:
        os.dup2(before, 1)
        os.close(before)
        os.close(nothing)
