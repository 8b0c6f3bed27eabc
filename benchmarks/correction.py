"""How level the touch signal is over the area: `python benchmarks/correction.py [SEED ...]`.

Calibrates on virtual rooms as a user does, then touches 35 places of the area at natural angles.
It prints how much the signal varies before and after the correction, and what the interpolation on
the grid costs in time and accuracy.
"""

from __future__ import annotations

import sys
import time
from contextlib import ExitStack

import numpy as np

from halo_calibration.base_model import choose_base
from halo_calibration.guided.guide import PROMPTS
from halo_calibration.observe import Observation, Observer
from halo_calibration.solvers.correction import Model
from halo_calibration.solvers.sweep import SWEEP_S
from halo_calibration.steps import Setup, sweep_change, watch_sweep
from halo_calibration.steps.session import Session
from halo_service.app.hand_detector import HandDetector
from halo_service.app.virtual_user.profile import virtual_profile
from halo_service.app.virtual_user.user import STATE_VALUES, VirtualUser
from halo_service.profile import Profile
from halo_service.sensing.correction import strength
from halo_service.settings import Settings
from halo_service.virtual.hand import pointing
from halo_service.virtual.room import Room
from halo_service.virtual.sensor import Sensor
from halo_service.virtual.sim_url import parse_sim_url
from halo_service.virtual.skeleton import FingerPose, posed

SETTLE_S = 2.0


def main() -> int:
    """Print one line a seed."""
    for seed in [int(each) for each in sys.argv[1:]] or [1, 2, 3]:
        room = parse_sim_url(f"sim?seed={seed}").room
        profile = calibrated(room)
        observed = touch_all_over(room, profile)
        raw = np.array([each.raw for each in observed])
        corrected = np.array([each.corrected for each in observed])
        print(
            f"seed {seed} {room.material:8} {len(observed):3} touches  variation raw "
            f"{variation(raw):.3f} corrected {variation(corrected):.3f} "
            f"ratio {variation(corrected) / variation(raw):.2f}  {interpolation(profile)}",
            flush=True,
        )
    return 0


def calibrated(room: Room) -> Profile:
    """Run all steps in a room."""
    settings = Settings()
    profile = virtual_profile(room, settings)
    user = VirtualUser(room)
    session = Session(user)
    setup = Setup(
        "bench",
        user.camera,
        "",
        state_values=STATE_VALUES,
        base=choose_base("auto", user.camera.serial),
    )
    with ExitStack() as stack:
        detector = HandDetector(user.camera, profile, settings.tracking)
        stack.callback(detector.close)
        user.follow(PROMPTS["sweep"])
        user.skip(SETTLE_S)
        observer = Observer(profile, detector.detect, settings.sensing)
        frames = session.lasting(SWEEP_S, "sweep")
        swept = watch_sweep(frames, session.frame_count(SWEEP_S), observer, lambda seen: None)
        return sweep_change(setup, swept, profile)(profile)


def touch_all_over(room: Room, profile: Profile) -> list[Observation]:
    """Touch all over the area, at 25 g, without a wedge."""
    settings = Settings()
    sensor, rng, seen = Sensor(room, colour_times=2), np.random.default_rng(room.seed), []
    with ExitStack() as stack:
        detector = HandDetector(sensor.camera, profile, settings.tracking)
        stack.callback(detector.close)
        observer = Observer(profile, detector.detect, settings.sensing)
        number = 0
        for x in np.linspace(30.0, 270.0, 7):
            for y in np.linspace(30.0, 170.0, 5):
                aim = FingerPose(x, y, 0.0, 25.0, rng.uniform(38.0, 52.0), rng.uniform(-20.0, 20.0))
                hand = posed(room.user, pointing(room.user, room.dominant, aim, curl=1.0))
                for _ in range(3):
                    number += 1
                    observation = observer.see(sensor.frame(number * 33_333, [hand]))
                if observation is not None:
                    seen.append(observation)
    return seen


def interpolation(profile: Profile) -> str:
    """Compare the grid with the regressor on the samples, and time it."""
    correction = profile.correction
    assert correction is not None
    base = choose_base("auto", profile.camera.serial)
    samples = correction.samples.astype(np.float64)
    model = Model(profile.surface, base, samples)
    started = time.perf_counter()
    grid = np.array([strength(correction, *row) for row in samples[:, :4].tolist()])
    microseconds = 1e6 * (time.perf_counter() - started) / len(samples)
    expected = model.expect(samples[:, :4])
    off = np.abs(grid / np.median(grid / expected) / expected - 1.0)
    return (
        f"grid against regressor: median {np.median(off):.3f}, p95 {np.percentile(off, 95):.3f}, "
        f"{microseconds:.0f} us a call"
    )


def variation(signal: np.ndarray) -> float:
    """Standard deviation over mean."""
    return float(np.std(signal) / np.mean(signal))


if __name__ == "__main__":
    raise SystemExit(main())
