"""What calibration learnt of one place and user, and how it is kept."""

from halo_service.profile.model import Background, HeldState, Profile, TouchStates

__all__ = ["Background", "HeldState", "Profile", "TouchStates"]
