"""`halo canvas draw`: a picture of what nodes and canvas report for some seconds."""

from __future__ import annotations

import logging
import threading
import time
from collections.abc import Sequence
from contextlib import ExitStack
from pathlib import Path

import cv2

import halo_protocol as wire
from halo_client import ZenohSource
from halo_service.app.canvas.nodes import follow_nodes
from halo_service.app.following import received_events
from halo_service.canvas.canvas import Canvas
from halo_service.canvas.detections import SurfaceKey
from halo_service.canvas.layout import Layout
from halo_service.canvas.picture import Picture
from halo_service.errors import UserError
from halo_service.files import appearing
from halo_service.host_clock import CLOCK

log = logging.getLogger(__name__)


class Drawer:
    """Merges what arrives, and draws it."""

    def __init__(self, layout: Layout) -> None:
        self._lock = threading.Lock()
        self._canvas = Canvas(layout)
        self.picture = Picture(layout)

    @property
    def nodes(self) -> list[SurfaceKey]:
        """All surfaces of the layout."""
        return list(self._canvas.nodes)

    def handle(self, surface: SurfaceKey, events: Sequence[wire.Event]) -> None:
        """Note what arrived of one node; from any thread."""
        with self._lock:
            for event in received_events(events):
                self.add(surface, event, CLOCK.unix_us())

    def absent(self) -> list[SurfaceKey]:
        """Return the surfaces of which no frame has arrived."""
        with self._lock:
            return [surface for surface, node in self._canvas.nodes.items() if not node.frames]

    def add(self, surface: SurfaceKey, event: wire.Event, now_us: int) -> None:
        """Merge and draw what arrived."""
        merged = self._canvas.handle(surface, event, now_us)
        if isinstance(event, wire.TouchFrame):
            self.picture.add_node(self._canvas.nodes[surface].area, event)
        if merged is not None:
            self.picture.add(merged)


def draw(layout: Layout, source: ZenohSource, seconds: float, out: Path) -> None:
    """Follow the nodes for some seconds, and write a PNG. Raises `UserError`."""
    drawer = Drawer(layout)
    with ExitStack() as stack:
        follow_nodes(drawer.nodes, source, drawer.handle, stack)
        time.sleep(seconds)
    if absent := drawer.absent():
        names = " or ".join("/".join(each) for each in absent)
        text = f"canvas: no frame of {names} arrived within {seconds:g} s; see 'halo list'"
        if len(absent) == len(layout.surface):
            raise UserError(text)
        log.warning("%s", text)
    save(drawer.picture, out)


def save(picture: Picture, out: Path) -> None:
    """Write a PNG. Raises `UserError`."""
    _, data = cv2.imencode(".png", picture.drawn())
    try:
        with appearing(out) as file:
            file.write(data.tobytes())
    except OSError as error:
        raise UserError(f"{out} cannot be written ({error.strerror})") from error
