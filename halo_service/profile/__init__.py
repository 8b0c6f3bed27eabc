"""What calibration learnt of one place and user, and how it is kept."""

from halo_service.profile.model import (
    Background,
    Correction,
    HeldState,
    Profile,
    StepRecord,
    TouchStates,
)

__all__ = ["Background", "Correction", "HeldState", "Profile", "StepRecord", "TouchStates"]
