"""What calibration learnt of one place and user, and how it is kept."""

from halo_service.profile.model import (
    Anchor,
    Background,
    Correction,
    HeldState,
    Profile,
    Projector,
    StepRecord,
    TouchStates,
)

__all__ = [
    "Anchor",
    "Background",
    "Correction",
    "HeldState",
    "Profile",
    "Projector",
    "StepRecord",
    "TouchStates",
]
