"""Planes and states on every material, near and far, tilted: `python benchmarks/calibration.py`.

The truth is the virtual sensor's own; it is cold, so it reads 2 mm near, and its pattern is fixed.
"""

from __future__ import annotations

import numpy as np

from halo_service.app.virtual_user.profile import virtual_profile
from halo_service.errors import UserError
from halo_service.settings import Settings
from halo_service.virtual.materials import MATERIALS
from halo_service.virtual.sim_url import parse_sim_url

PLACES = ((450, -5.0, 3.0), (700, 5.0, -4.0))
"""Camera height in mm, pitch and yaw in degrees."""


def main() -> int:
    """Print one line a material and place."""
    for seed, material in enumerate(MATERIALS, start=10):
        for height_mm, pitch_deg, yaw_deg in PLACES:
            name = (
                f"sim?seed={seed}&material={material}&camera_height_mm={height_mm}"
                f"&camera_pitch_deg={pitch_deg}&camera_yaw_deg={yaw_deg}"
            )
            print(f"{material:8} {height_mm} mm  {line(name)}", flush=True)
    return 0


def line(name: str) -> str:
    """Calibrate in one room and compare."""
    room = parse_sim_url(name).room
    try:
        profile = virtual_profile(room, Settings())
    except UserError as error:
        return str(error)
    true = room.surface().camera_from_surface[:3, 2]
    found = profile.surface.camera_from_surface[:3, 2]
    off_deg = float(np.degrees(np.arccos(min(float(true @ found), 1.0))))
    off_mm = profile.steps["surface"].figures["distance_mm"] - room.camera_height_mm
    figures = profile.steps["touch"].figures
    states = " < ".join(
        f"{figures[f'{s}_mm_px']:.0f}" for s in ("hover", "subtle", "touch", "pressure")
    )
    return (
        f"plane {off_mm:+.2f} mm {off_deg:.2f} deg  threshold {profile.halo_threshold_mm} mm  "
        f"{room.curve.family:11} {states}  {figures['separation_sigmas']:.0f} sigmas"
    )


if __name__ == "__main__":
    raise SystemExit(main())
