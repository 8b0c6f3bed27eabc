"""Opens a source by its name."""

from __future__ import annotations

import logging
import re
import time
from collections.abc import Callable
from dataclasses import replace
from math import ceil
from pathlib import Path

from halo_service.app.cameras.found import choose, first_camera
from halo_service.errors import UserError, suggestion
from halo_service.files import from_home
from halo_service.settings import SourceSettings
from halo_service.sources import Source
from halo_service.sources.camera_name import CAMERA_KINDS, kind_of, parse_camera_name

log = logging.getLogger(__name__)

ANY_CAMERA = "camera"
"""Whatever camera is plugged in, and never the virtual one."""
KNOWN = (*CAMERA_KINDS, ANY_CAMERA, "recording:FILE", "sim[:SCENARIO]", "auto")


def open_source(
    settings: SourceSettings, serial: str = "", sleep: Callable[[float], None] = time.sleep
) -> tuple[Source, Callable[[], Source]]:
    """Open a source; return it, and a function that opens the same one again if it is lost.

    `auto` decides once and logs it: if a camera is unplugged later, the service waits for it and
    never replaces it by a virtual one. `serial`: of the camera that a profile belongs to; it is
    opened unless the source names another. Raises `UserError` if the source is unknown or missing.
    """
    name = settings.name
    if (name in ("auto", ANY_CAMERA) or kind_of(name)) and settings.wait_s > 0.0:
        _wait_for_camera(settings.wait_s, sleep)
    if name == "auto":
        name = decide(serial)
    elif name == ANY_CAMERA:
        name = _any_camera(serial)
    kind = "sim" if is_sim(name) else name.partition(":")[0]
    if kind != "recording" and (settings.loop or settings.fast):
        raise UserError("--loop and --fast work only with --source recording:FILE")
    opener = _opener(kind, name, settings, serial)
    source = opener()
    if source.kind == "camera":
        from halo_service.sources.warm_up import warm_up_note

        log.warning("camera: %s", warm_up_note(source))
        if not serial:  # with two cameras, the first may be another later
            return source, _opener(kind, name, settings, source.camera.serial)
    return source, opener


def is_sim(name: str) -> bool:
    """Say whether a source's name means the virtual camera."""
    return re.fullmatch(r"sim([:,?].*)?", name, re.DOTALL) is not None


def _wait_for_camera(seconds: float, sleep: Callable[[float], None]) -> None:
    """Wait until a camera is plugged in, at most so long."""
    for second in range(ceil(seconds)):
        if first_camera():
            return
        if second == 0:
            log.warning("source: waiting for a camera, at most %.0f s", seconds)
        sleep(1.0)


def decide(serial: str = "") -> str:
    """Return what `auto` means now, and log it. `serial`: of the camera that a profile belongs to.

    Raises `UserError` if there is a camera that cannot be used: it is never replaced silently.
    """
    chosen = choose(serial)
    if chosen is not None:
        log.warning("source: found the camera %s", chosen.title)
        return chosen.kind
    log.warning(
        "source: NO CAMERA FOUND, using the VIRTUAL camera: all touches are simulated "
        "(plug in a camera and start again, or choose with --source)"
    )
    return "sim"


def _any_camera(serial: str) -> str:
    chosen = choose(serial)
    if chosen is None:
        raise UserError(
            "source: no camera is plugged in: plug one in ('halo cameras' lists them), or choose "
            "another source: --source recording:FILE or --source sim"
        )
    return chosen.kind


def _opener(kind: str, name: str, settings: SourceSettings, serial: str) -> Callable[[], Source]:
    if kind_of(name):
        return _camera_opener(name, serial)
    rest = name.partition(":")[2]
    if kind == "recording" and rest:
        path = from_home(rest)
        return lambda: open_recording(path, realtime=not settings.fast, loop=settings.loop)
    if kind == "sim":
        from halo_service.virtual.live import VirtualKinect
        from halo_service.virtual.sim_url import parse_sim_url

        request = parse_sim_url(name)
        return lambda: VirtualKinect(request)
    hint = suggestion(name, KNOWN) or f"choose from: {', '.join(KNOWN)}"
    raise UserError(f"source: unknown source '{name}'; {hint}")


def open_recording(path: Path, *, realtime: bool = False, loop: bool = False) -> Source:
    """Open a recording by its form: `.bag` of Orbbec, else Matroska. Raises `UserError`.

    `realtime`: frames come when they are due, with Unix times; else at once, with the file's.
    """
    if path.suffix == ".bag":
        from halo_service.sources.orbbec.bag import Bag

        if loop:
            raise UserError(f"--loop does not work with {path}: make it a .mkv with 'halo record'")
        return Bag(path, realtime=realtime)
    from halo_service.sources.recording import Recording

    return Recording(path, realtime=realtime, loop=loop)


def _camera_opener(name: str, serial: str) -> Callable[[], Source]:
    kind, options = parse_camera_name(name)
    options = replace(options, serial=options.serial or serial)
    if kind == "azure-kinect":
        from halo_service.sources.azure_kinect import AzureKinect

        return lambda: AzureKinect(options)
    from halo_service.sources.orbbec.femto import Femto

    return lambda: Femto(kind, options)
