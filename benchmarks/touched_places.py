"""How true surface and projector are when found by touch: `python benchmarks/touched_places.py
[SEED ...]`.

A virtual person touches the corners of their area, then the nine projected crosses, as `halo
calibrate surface --by touch` and `projector --by touch` ask for; the sensing finds the finger. One
line a seed says how far from the truth a touch would then be reported, and how far from its target
light would fall. Some minutes a seed.
"""

from __future__ import annotations

import sys
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from halo_calibration.solvers.homography import mapped
from halo_service.app.cli import main as halo
from halo_service.app.virtual_user.user import AREA
from halo_service.geometry.camera import Points
from halo_service.profile import Profile
from halo_service.profile.store import load
from halo_service.virtual.room import HEIGHT_MM, WIDTH_MM, Room, draw_room

SHARES = np.array([(x, y) for y in (0.0, 0.5, 1.0) for x in (0.0, 0.5, 1.0)])
"""Places of a rectangle, from its far left corner."""
LIT = np.array([(x, y) for y in np.linspace(120, 680, 9) for x in np.linspace(150, 1130, 9)])
"""Pixels of the projector; those that fall outside the area do not count."""


def main() -> int:
    """Print one line a seed."""
    for seed in [int(each) for each in sys.argv[1:]] or [204, 205, 206]:
        room = draw_room(seed)
        with TemporaryDirectory() as folder:
            surface = surface_off_mm(room, found(seed, "surface", Path(folder)))
            projector = projector_off_mm(room, found(seed, "projector", Path(folder)))
        print(f"seed {seed}, {room.material}: surface {text(surface)}; projector {text(projector)}")
    return 0


def found(seed: int, step: str, folder: Path) -> Profile:
    """Calibrate the background and one step by touch. Ends the program where that is refused."""
    place = str(folder / step)
    for step_options in (["background"], [step, "--by", "touch"]):
        source = f"sim:calibration?seed={seed}"
        code = halo(["calibrate", *step_options, "--source", source, "--profile", place])
        if code != 0:
            raise SystemExit(code)
    return load(Path(place))


def surface_off_mm(room: Room, profile: Profile) -> Points:
    """(9,) of places over the touched area: from where they are to where they are reported."""
    far_left, far_right, _, near_left = np.array(AREA)
    across, down = far_right - far_left, near_left - far_left
    places = far_left + SHARES @ np.array([across, down])
    size_mm = np.linalg.norm(across), np.linalg.norm(down)
    return _apart(_seen(room, profile, places), SHARES * size_mm)


def projector_off_mm(room: Room, profile: Profile) -> Points:
    """(N,) of pixels on the area: from where a touch of their light is reported to where they are
    said to be."""
    assert profile.projector is not None  # it has just been found
    fallen = mapped(np.linalg.inv(room.projector.projector_from_surface()), LIT)
    on_area = ((fallen > 0.0) & (fallen < (WIDTH_MM, HEIGHT_MM))).all(axis=1)
    said = mapped(np.linalg.inv(profile.projector.projector_from_surface), LIT)
    return _apart(_seen(room, profile, fallen)[on_area], said[on_area])


def text(off_mm: Points) -> str:
    """Say mean and worst."""
    return f"{off_mm.mean():.1f} mm, at most {off_mm.max():.1f}"


def _seen(room: Room, profile: Profile, places: Points) -> Points:
    """(N, 2) of the room's surface in the calibrated one's frame."""
    points = np.column_stack([places, np.zeros(len(places))])
    return profile.surface.from_camera(room.surface().to_camera(points))[:, :2]


def _apart(a: Points, b: Points) -> Points:
    return np.asarray(np.linalg.norm(a - b, axis=1), dtype=np.float64)


if __name__ == "__main__":
    sys.exit(main())
