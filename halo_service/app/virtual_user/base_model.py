"""Makes the base model of the virtual camera: `python -m halo_service.app.virtual_user.base_model`.

Three virtual users on three tables sweep at five finger angles, at ten frames a second. The steps
of the calibration turn these frames into the samples of the model. It takes some minutes.
"""

from __future__ import annotations

import sys
from contextlib import ExitStack

from halo_calibration.base_model import VIRTUAL, write_base
from halo_calibration.guided.guide import Prompt
from halo_calibration.guided.pilot import ANGLES_DEG, merged, pilot_samples, usable
from halo_calibration.observe import Observer
from halo_calibration.solvers.sweep import SWEEP_S, Samples, samples_of
from halo_service.app.hand_detector import HandDetector
from halo_service.app.virtual_user.profile import virtual_profile
from halo_service.app.virtual_user.user import VirtualUser
from halo_service.settings import Settings
from halo_service.virtual.camera import SERIAL
from halo_service.virtual.sim_url import parse_sim_url

PILOTS = (
    "sim?seed=901&material=paper&seat_deg=0",
    "sim?seed=905&material=wood&seat_deg=0",
    "sim?seed=903&material=foam&seat_deg=0",
)
"""Seeds that no test, scenario or benchmark uses. Pilots sit at the near edge; these
can be calibrated on the `true` sensor too (902 on wood cannot)."""
TENTH_S = 0.1
"""Time between two frames that are used: neighbours in time are too similar."""
SETTLE_S = 2.0


def main() -> int:
    """Make the model; the same on every run."""
    settings = Settings()
    pilots = [_pilot(name, settings) for name in PILOTS]
    base = merged("virtual", SERIAL, pilots)
    write_base(base, VIRTUAL)
    print(f"{VIRTUAL}: {len(base.relative)} samples", file=sys.stderr)
    return 0


def _pilot(name: str, settings: Settings) -> Samples:
    room = parse_sim_url(name).room
    profile = virtual_profile(room, settings)
    user = VirtualUser(room)
    rounds: list[tuple[float, Samples]] = []
    with ExitStack() as stack:
        detector = HandDetector(user.camera, profile, settings.tracking)
        stack.callback(detector.close)
        for angle in ANGLES_DEG:
            observer = Observer(profile, detector.detect, settings.sensing)
            user.follow(Prompt("pilot", "", angle))
            user.skip(SETTLE_S)
            seen = []
            for _ in range(round(SWEEP_S / TENTH_S)):
                observation = observer.see(user.read(0.0))
                user.skip(TENTH_S - 1.0 / user.camera.fps)
                if observation is not None:
                    seen.append(observation)
            rounds.append((angle, usable(samples_of(seen), angle)))
            print(f"{name} at {angle:g}: {len(rounds[-1][1])} samples", file=sys.stderr)
    return pilot_samples(profile.surface, rounds)


if __name__ == "__main__":
    raise SystemExit(main())
