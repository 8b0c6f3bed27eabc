"""The cameras that are plugged in, on the page."""

from __future__ import annotations

import sys
from typing import Any

from halo_service.app.cameras.found import found_cameras, installed_sdks, merge
from halo_service.sources.usb import usb_cameras
from halo_service.web.control_page.calls import Call


class CameraCalls:
    """Lists cameras."""

    def table(self) -> dict[str, Call]:
        """Return the calls."""
        return {"cameras": Call(self._read, reads=True)}

    def _read(self, request: dict[str, Any]) -> dict[str, Any]:
        del request
        # Where the system shows USB devices, no SDK need be loaded into a running service.
        on_usb = sys.platform == "linux"
        cameras = merge(usb_cameras(), installed_sdks()) if on_usb else found_cameras()
        return {"cameras": [camera.as_dict() for camera in cameras]}
