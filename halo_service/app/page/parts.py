"""What the page is made from; light, so that a service without a page loads nothing else."""

from __future__ import annotations

import threading
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from halo_service.outputs.osc import OscOutput
from halo_service.settings import Settings
from halo_service.sources.switched import SwitchedSource

if TYPE_CHECKING:
    from halo_service.app.service.profile_reloader import ProfileReloader
    from halo_service.web.server import WebServer


@dataclass(frozen=True, slots=True)
class PageRequest:
    """What the command line says of the page."""

    config: Path | None = None
    """The settings file that the page changes."""
    opens: bool = False
    """Open it in this machine's browser."""


@dataclass(frozen=True, slots=True)
class Parts:
    """The parts of the service that the page works with."""

    settings: Settings
    source: SwitchedSource
    """Shows a recording in the camera's place."""
    osc: OscOutput
    web: WebServer | None
    zenoh: tuple[str, ...]
    """Its endpoints; empty where it is off."""
    reloader: ProfileReloader
    fit: Callable[[], str]
    paused: threading.Event
    """Set while frames have no pointers and need no hand tracker."""
