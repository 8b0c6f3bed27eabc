"""What calibration measured of one place and user, and how it is stored."""

from halo_service.profile.model import (
    Anchor,
    Background,
    Correction,
    Profile,
    Projector,
    StepRecord,
    TouchState,
    TouchStates,
)

__all__ = [
    "Anchor",
    "Background",
    "Correction",
    "Profile",
    "Projector",
    "StepRecord",
    "TouchState",
    "TouchStates",
]
