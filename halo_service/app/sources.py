"""Opens the source that a name stands for."""

from __future__ import annotations

import logging
from collections.abc import Callable

from halo_service.errors import UserError
from halo_service.files import from_home
from halo_service.settings import SourceSettings
from halo_service.sources import Source

log = logging.getLogger(__name__)

KNOWN = "azure-kinect, recording:FILE, sim[:SCENARIO], auto"


def open_source(settings: SourceSettings) -> tuple[Source, Callable[[], Source]]:
    """Open a source; return it, and how to open the very same again if it is lost.

    `auto` decides once, loudly: what it found is then the configured source, so a camera that is
    unplugged in the evening is waited for, and never replaced by a virtual one.
    Raises `UserError` where the source is unknown or not there.
    """
    name = decide() if settings.name == "auto" else settings.name
    kind, _, rest = name.partition(":")
    if kind != "recording" and (settings.loop or settings.fast):
        raise UserError("--loop and --fast go with --source recording:FILE; only that has an end")
    opener = _opener(kind, rest, name, settings)
    return opener(), opener


def decide() -> str:
    """Say, loudly, what `auto` means today."""
    from halo_service.sources.azure_kinect import connected

    cameras = connected()
    if cameras:
        log.warning("source: an Azure Kinect is plugged in, so that is the source")
        return "azure-kinect"
    log.warning(
        "source: NO AZURE KINECT FOUND, so this is the VIRTUAL Kinect; what it shows is simulated "
        "(plug one in and start again, or say --source to choose)"
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
    raise UserError(f"source: '{name}' is none; known: {KNOWN}")
