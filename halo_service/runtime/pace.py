"""A hand tracker that leaves out frames, for the surface of a profile."""

from __future__ import annotations

from collections.abc import Callable

from halo_service.hand_tracking.paced_tracker import PacedTracker
from halo_service.profile import Profile
from halo_service.values import Frame, Tracked


def paced_by_depth(
    look: Callable[[Frame], Tracked], profile: Profile, max_hands: int
) -> Callable[[Frame], Tracked]:
    """Return a tracker that looks only where depth does not confirm the hands it found last.

    `profile`: its background has valid pixels; `max_hands`: how many `look` finds at most.
    """
    background, focal_px = profile.background, profile.camera.depth.fx
    return PacedTracker(look, background.mean_mm, background.valid, focal_px, max_hands).detect
