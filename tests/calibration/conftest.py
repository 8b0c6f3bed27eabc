"""A camera with a lens that bends, and fingers that hold still."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest

from halo_calibration.observe import Observation
from halo_calibration.solvers.touch import HoldObservations
from halo_service.geometry.camera import Camera, Lens
from halo_service.values import Side


@pytest.fixture(scope="session")
def lens_camera() -> Camera:
    distortion = (0.5, -0.02, 1e-5, -7e-5, -0.003, 0.85, 0.09, -0.01)
    lens = Lens(640, 576, 504.0, 504.0, 321.0, 330.0, distortion)
    return Camera("A1", "NFOV_UNBINNED", 30, lens, None, np.eye(4))


Hold = Callable[..., HoldObservations]


@pytest.fixture(scope="session")
def hold() -> Hold:
    """A held state: `raw` mm px with some noise, all 60 frames, by default.

    Its depths are a 200th of the signal, or `dent_mm` and to and fro by `sways_mm`, and not seen in
    the first `hidden` frames.
    """

    def held(
        state: str,
        raw: float,
        *,
        noise: float = 20.0,
        received: int = 60,
        seen: int | None = None,
        moved_mm: float = 0.0,
        dent_mm: float | None = None,
        sways_mm: float = 0.0,
        hidden: int = 0,
    ) -> HoldObservations:
        depth_mm = raw / 200.0 if dent_mm is None else dent_mm
        rng = np.random.default_rng(len(state))
        count = received if seen is None else seen
        observations = tuple(
            Observation(
                n * 33_333,
                Side.RIGHT,
                150.0 + moved_mm * n / max(count, 1) + rng.normal(0.0, 0.5),
                100.0 + rng.normal(0.0, 0.5),
                45.0,
                0.0,
                26.0 if state == "hover" else 9.0,
                max(raw + rng.normal(0.0, noise), 0.0),
                0.0,
                5,
                (math.nan if n < hidden else depth_mm + sways_mm * (-1) ** n,) * 3,
                13.0,
            )
            for n in range(count)
        )
        return HoldObservations(state, 60, received, observations)

    return held
