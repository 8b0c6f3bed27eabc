"""The fingers that a running service tells of, for `halo verify --from`."""

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
"""For a running service to tell where the projector's pixels are; it does so twice a second."""


class _Told(NamedTuple):
    where: tuple[str, str]
    """Node and surface: others may send to the same port."""
    scene: wire.Scene
    homography: wire.Homography


def heard(url: str, screen: ScreenRequest) -> Grid:
    """Hear a service at an address (`osc://...`) until all is touched, the display is closed or
    Ctrl-C. Raises `UserError`."""
    try:
        receiver = halo_client.receive(url, everything=True)
    except halo_client.ClientError as error:
        raise UserError(f"verify: {error}") from error
    with receiver, Display(screen.display, full_screen=not screen.window) as display:
        told = _told_by(receiver)
        scene, homography = told.scene, told.homography
        matrix = np.array(homography.projector_from_surface).reshape(3, 3)
        size_px = homography.width_px, homography.height_px
        grid = grid_over(scene.width_mm, scene.height_mm, matrix, size_px, display)
        verification = Verification(grid, display)
        with suppress(KeyboardInterrupt):
            _follow(receiver, told, verification)
    return grid


def _follow(receiver: halo_client.Receiver, told: _Told, verification: Verification) -> None:
    scene = told.scene
    for frame in receiver.frames(1.0):
        if frame is not None and (frame.node, frame.surface) == told.where:
            fingers = [Finger(p.x_mm, p.y_mm, p.touching) for p in frame.pointers]
            downs = [(d.u * scene.width_mm, d.v * scene.height_mm) for d in frame.downs]
            verification.take(fingers, downs)
        if verification.done:
            return


def _told_by(receiver: halo_client.Receiver) -> _Told:
    """Wait for what a service says of its surface and its projector."""
    until_s = time.monotonic() + WAIT_S
    while time.monotonic() < until_s:
        receiver.poll(0.25)
        for where, homography in receiver.services.homographies.items():
            scene = receiver.services.scenes.get(where)
            if scene is not None:
                return _Told(where, scene, homography)
    found = "tells of no projector" if receiver.services.scenes else "is not heard"
    raise UserError(
        f"verify: a service at {receiver.url} {found}: start 'halo serve' with a profile whose "
        f"projector is calibrated ('halo calibrate projector')"
    )
