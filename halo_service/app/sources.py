"""Opens a source by its name."""

from __future__ import annotations

import logging
from collections.abc import Callable

from halo_service.errors import UserError, suggestion
from halo_service.files import from_home
from halo_service.settings import SourceSettings
from halo_service.sources import Source

log = logging.getLogger(__name__)

KNOWN = ("azure-kinect", "recording:FILE", "sim[:SCENARIO]", "auto")


def open_source(settings: SourceSettings) -> tuple[Source, Callable[[], Source]]:
    """Open a source; return it, and a function that opens the same one again if it is lost.

    `auto` decides once and logs it: if a camera is unplugged later, the service waits for it and
    never replaces it by a virtual one. Raises `UserError` if the source is unknown or missing.
    """
    name = decide() if settings.name == "auto" else settings.name
    kind, _, rest = name.partition(":")
    if kind != "recording" and (settings.loop or settings.fast):
        raise UserError("--loop and --fast work only with --source recording:FILE")
    opener = _opener(kind, rest, name, settings)
    return opener(), opener


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


def _opener(kind: str, rest: str, name: str, settings: SourceSettings) -> Callable[[], Source]:
    if kind == "azure-kinect" and not rest:
        from halo_service.sources.azure_kinect import AzureKinect

        return AzureKinect
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
