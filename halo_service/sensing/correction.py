"""Stage 5: what the signal would be at the place and angle of the calibration.

The paper (4.3.4) predicts the expected touch signal from tip position, pitch and yaw with a
gradient-boosted regressor. Until a profile carries such a model the correction is the identity.
"""

from __future__ import annotations

from halo_service.values import Fingertip


def correct(raw: float, tip: Fingertip) -> float:
    """Return the corrected signal, mm px: for now the raw one, wherever the tip is."""
    del tip
    return raw
