"""What the page sees of the live loop.

Rule: the frame's thread only notes references; everything else happens in other threads, after the
frame's packet has left.
"""

from __future__ import annotations

import json
import logging
import os
import time
from collections import deque
from collections.abc import Callable
from dataclasses import replace
from typing import Any

from halo_service.app.page.feed import frame_value, health_value, scene_value
from halo_service.app.page.log_lines import LogLines
from halo_service.app.page.pictures import Look
from halo_service.geometry.camera import Camera
from halo_service.outputs.test_pattern import Pattern
from halo_service.runtime.health import Health
from halo_service.runtime.live import Publisher
from halo_service.sensing import State
from halo_service.values import Frame, TouchFrame
from halo_service.web.control_page.client import PageClient
from halo_service.web.control_page.server import PageServer

PATTERN_ID = 1_000_000
"""Pointers of the test pattern begin here, far from those of fingers."""
SCENE_S = 0.5
"""How often it is looked for a changed scene."""


class PageObserver:
    """A `Publisher` around the service's own, which also tells the page."""

    def __init__(
        self,
        inner: Publisher,
        server: PageServer,
        camera: Camera,
        fit: Callable[[], str],
        counts: Callable[[], dict[str, Any]],
    ) -> None:
        """`fit`: whether the profile fits; `counts`: clients of the outputs."""
        self._inner, self._server, self._camera = inner, server, camera
        self._fit, self._counts = fit, counts
        self._touch_frame: TouchFrame | None = None
        self._frame: Frame | None = None
        self._state: State | None = None
        self._scene: dict[str, Any] = {}
        self._health: dict[str, Any] = {}
        self._scene_s = float("-inf")
        self._cpu = (time.monotonic(), _cpu_s())
        self._requests: deque[Callable[[State], State]] = deque(maxlen=64)
        self._pattern: Pattern | None = None
        self._pattern_began_us = 0
        self._pattern_last_s = -1.0
        self._patterns = 0
        self.newest: Look | None = None
        self.taps: set[Callable[[Frame], None]] = set()
        """Each gets every camera frame: a recording, the wizard."""
        self.touch_taps: set[Callable[[TouchFrame], None]] = set()
        """Each gets every frame of touches."""
        self.about_source: Callable[[], dict[str, Any]] = dict
        """Returns where the frames come from now, for the scene."""
        self.about: dict[str, Any] = {}
        """Facts of the service that do not change."""
        self.log = LogLines()
        logging.getLogger().addHandler(self.log)
        self.log.on_line = lambda line: server.post(lambda: server.broadcast(line))

    def close(self) -> None:
        """Forward no more lines of the log."""
        logging.getLogger().removeHandler(self.log)

    def greet(self, client: PageClient) -> None:
        """Send a page that opens what is known; in the server's thread."""
        hello = {"kind": "hello", "role": client.role, **self.about}
        for value in (hello, self._scene, self._health, *self.log.lines()[-100:]):
            if value:
                client.put(json.dumps(value, separators=(",", ":")))

    # As the publisher of the live loop.

    def frame(self, touch_frame: TouchFrame) -> None:
        """Publish a frame, or the test pattern in its place."""
        if self._pattern is not None:
            touch_frame = self._pattern_frame(self._pattern, touch_frame)
        self._inner.frame(touch_frame)
        self._touch_frame = touch_frame
        for tap in tuple(self.touch_taps):
            tap(touch_frame)

    def scene(self, state: State) -> None:
        """Publish the scene."""
        self._inner.scene(state)

    def health(self, health: Health) -> None:
        """Publish the health."""
        self._inner.health(health)
        now = time.monotonic(), _cpu_s()
        cpu = (now[1] - self._cpu[1]) / max(now[0] - self._cpu[0], 1e-3)
        self._cpu = now
        self._health = health_value(health, cpu, self._fit(), self._counts())
        self._server.post(lambda: self._server.broadcast(self._health))

    # In the live loop, after a packet has left.

    def request(self, change: Callable[[State], State]) -> None:
        """Change the state before the next frame; from any thread."""
        self._requests.append(change)

    def turn(self, state: State) -> State:
        """Apply what the page asked for, and hand over what there is to show."""
        while self._requests:
            state = self._requests.popleft()(state)
        self._state = state
        touch_frame, self._touch_frame = self._touch_frame, None
        if touch_frame is not None and self._server.clients:
            self._server.post(lambda: self._server.broadcast(frame_value(touch_frame)))
            self.newest = self._looked(touch_frame, state)
        now_s = time.monotonic()
        if now_s - self._scene_s >= SCENE_S:
            self._scene_s = now_s
            self._server.post(lambda: self._show_scene(state))
        return state

    @property
    def needs_colour(self) -> bool:
        """Whether a page shows the colour picture, or a recording or the wizard runs."""
        return bool(self.taps) or self._server.shows("colour")

    def watch(self, frame: Frame) -> None:
        """Note a camera frame."""
        self._frame = frame
        for tap in tuple(self.taps):
            tap(frame)

    def _looked(self, touch_frame: TouchFrame, state: State) -> Look | None:
        if self._frame is None:
            return None
        return Look(self._frame, touch_frame, self._camera, state.profile, state.drift.offset_mm)

    def _show_scene(self, state: State) -> None:
        scene = {**scene_value(state), **self.about_source()}
        if scene != self._scene:
            self._scene = scene
            self._server.broadcast(scene)

    # The test pattern.

    def start_pattern(self) -> None:
        """Publish the test pattern instead of touches, from the next frame on."""
        state = self._state
        surface = state.profile.surface if state and state.profile else None
        self._patterns += 1
        self._pattern_last_s = -1.0
        pattern = Pattern(pointer_id=PATTERN_ID + self._patterns)
        self._pattern = (
            pattern
            if surface is None
            else replace(
                pattern,
                surface=surface.name,
                width_mm=surface.width_mm,
                height_mm=surface.height_mm,
            )
        )

    def stop_pattern(self) -> None:
        """Publish touches again."""
        self._pattern = None

    @property
    def shows_pattern(self) -> bool:
        """Whether the test pattern is published."""
        return self._pattern is not None

    def _pattern_frame(self, pattern: Pattern, touch_frame: TouchFrame) -> TouchFrame:
        time_us = touch_frame.time_us
        if self._pattern_last_s < 0.0:
            self._pattern_began_us = time_us
        t_s = max((time_us - self._pattern_began_us) / 1e6, 0.0)
        frame = pattern.frame(t_s, self._pattern_last_s, time_us)
        self._pattern_last_s = t_s
        return frame


def _cpu_s() -> float:
    """Return the processor time of this process so far."""
    used = os.times()
    return used.user + used.system
