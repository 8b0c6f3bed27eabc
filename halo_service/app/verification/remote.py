"""Touches of a running service, for `halo verify --from`."""

from __future__ import annotations

import time
from contextlib import suppress
from typing import NamedTuple

import numpy as np

import halo_client
import halo_protocol as wire
from halo_service.app.projector.display import Display
from halo_service.app.projector.screens import ScreenRequest
from halo_service.app.verification.crossings import Finger, Grid
from halo_service.app.verification.session import Verification, grid_over
from halo_service.errors import UserError

WAIT_S = 10.0
"""Time for a service to send its projector calibration; it sends it twice a second."""


class _ServiceScene(NamedTuple):
    where: tuple[str, str]
    """Node and surface: other services may send to the same port."""
    scene: wire.Scene
    homography: wire.Homography


def grid_from_service(url: str, screen: ScreenRequest) -> Grid:
    """Count the touches of a service (`osc://...`) until all crossings are touched, the display is
    closed or Ctrl-C. Raises `UserError`."""
    try:
        receiver = halo_client.connect(url, everything=True)
    except halo_client.ClientError as error:
        raise UserError(f"verify: {error}") from error
    with receiver, Display(screen.display, full_screen=not screen.window) as display:
        seen = _wait_for_scene(receiver)
        scene, homography = seen.scene, seen.homography
        matrix = np.array(homography.projector_from_surface).reshape(3, 3)
        size_px = homography.width_px, homography.height_px
        grid = grid_over(scene.width_mm, scene.height_mm, matrix, size_px, display)
        verification = Verification(grid, display)
        with suppress(KeyboardInterrupt):
            _follow(receiver, seen, verification)
    return grid


def _follow(
    receiver: halo_client.Receiver, seen: _ServiceScene, verification: Verification
) -> None:
    scene = seen.scene
    for frame in receiver.frames(1.0):
        if frame is not None and (frame.node, frame.surface) == seen.where:
            fingers = [Finger(p.x_mm, p.y_mm, p.touching) for p in frame.pointers]
            downs = [(d.u * scene.width_mm, d.v * scene.height_mm) for d in frame.downs]
            verification.update(fingers, downs)
        if verification.done:
            return


def _wait_for_scene(receiver: halo_client.Receiver) -> _ServiceScene:
    """Wait for the surface and the projector of a service."""
    until_s = time.monotonic() + WAIT_S
    while time.monotonic() < until_s:
        receiver.poll(0.25)
        for where, homography in receiver.services.homographies.items():
            scene = receiver.services.scenes.get(where)
            if scene is not None:
                return _ServiceScene(where, scene, homography)
    found = "sends no projector" if receiver.services.scenes else "sends nothing"
    raise UserError(
        f"verify: the service at {receiver.url} {found}: start 'halo serve' with a profile that "
        f"has a calibrated projector ('halo calibrate projector')"
    )
