"""Opens a source by its name."""

from __future__ import annotations

import logging
import re
import time
from collections.abc import Callable
from math import ceil

from halo_service.errors import UserError, suggestion
from halo_service.files import from_home
from halo_service.settings import SourceSettings
from halo_service.sources import Source

log = logging.getLogger(__name__)

KNOWN = ("azure-kinect", "azure-kinect:SERIAL", "recording:FILE", "sim[:SCENARIO]", "auto")


def open_source(
    settings: SourceSettings, serial: str = "", sleep: Callable[[float], None] = time.sleep
) -> tuple[Source, Callable[[], Source]]:
    """Open a source; return it, and a function that opens the same one again if it is lost.

    `auto` decides once and logs it: if a camera is unplugged later, the service waits for it and
    never replaces it by a virtual one. `serial`: of the camera that a profile belongs to; it is
    opened unless the source names another. Raises `UserError` if the source is unknown or missing.
    """
    name = settings.name
    if name.partition(":")[0] in ("auto", "azure-kinect") and settings.wait_s > 0.0:
        _wait_for_camera(settings.wait_s, sleep)
    if name == "auto":
        name = decide()
    kind, _, rest = name.partition(":")
    if is_sim(name):
        kind = "sim"
    if kind != "recording" and (settings.loop or settings.fast):
        raise UserError("--loop and --fast work only with --source recording:FILE")
    opener = _opener(kind, rest, name, settings, serial)
    source = opener()
    if source.kind == "camera" and not serial:  # with two cameras, the first may be another later
        return source, _opener(kind, source.camera.serial, name, settings, serial)
    return source, opener


def is_sim(name: str) -> bool:
    """Say whether a source's name means the virtual camera."""
    return re.fullmatch(r"sim([:,?].*)?", name, re.DOTALL) is not None


def _wait_for_camera(seconds: float, sleep: Callable[[float], None]) -> None:
    """Wait until a camera is connected, at most so long."""
    from halo_service.sources.azure_kinect import connected

    for second in range(ceil(seconds)):
        if connected():
            return
        if second == 0:
            log.warning("source: waiting for an Azure Kinect, at most %.0f s", seconds)
        sleep(1.0)


def decide() -> str:
    """Return what `auto` means now, and log it."""
    from halo_service.sources.azure_kinect import connected

    cameras = connected()
    if cameras:
        log.warning("source: found an Azure Kinect")
        return "azure-kinect"
    log.warning(
        "source: NO AZURE KINECT FOUND, using the VIRTUAL camera: all touches are simulated "
        "(plug in a camera and start again, or choose with --source)"
    )
    return "sim"


def _opener(
    kind: str, rest: str, name: str, settings: SourceSettings, serial: str
) -> Callable[[], Source]:
    if kind == "azure-kinect":
        from halo_service.sources.azure_kinect import AzureKinect

        return lambda: AzureKinect(rest or serial)
    if kind == "recording" and rest:
        from halo_service.sources.recording import Recording

        path = from_home(rest)
        return lambda: Recording(path, realtime=not settings.fast, loop=settings.loop)
    if kind == "sim":
        from halo_service.virtual.live import VirtualKinect
        from halo_service.virtual.sim_url import parse_sim_url

        request = parse_sim_url(name)
        return lambda: VirtualKinect(request)
    hint = suggestion(name, KNOWN) or f"choose from: {', '.join(KNOWN)}"
    raise UserError(f"source: unknown source '{name}'; {hint}")
