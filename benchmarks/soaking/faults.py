"""Faults of camera, tracker and clock (`tests/faults.py`), and how `health` reports each."""

from __future__ import annotations

from collections.abc import Callable

from halo_protocol import Camera, Health, ProfileFit, Tracker
from tests.faults import Fault

LEAKED_MB = 100

Shows = Callable[[Health, Health], bool]
"""Whether the later health reports the fault that began after the earlier one."""


def _camera(state: Camera) -> Shows:
    return lambda before, after: after.camera == state


def bad(before: Health, after: Health) -> bool:
    """Return whether there are more bad frames."""
    return after.bad_frames > before.bad_frames


def _fit(before: Health, after: Health) -> bool:
    return after.profile_fit == ProfileFit.TILTED


def _dropped(before: Health, after: Health) -> bool:
    return after.drops > before.drops


def _stepped(before: Health, after: Health) -> bool:
    return after.clock_jumps > before.clock_jumps


def _failed(before: Health, after: Health) -> bool:
    return after.tracker == Tracker.FAILED


def _leaks(before: Health, after: Health) -> bool:
    return after.memory_mb > before.memory_mb + LEAKED_MB


SWITCHED: dict[Fault, tuple[float, Shows]] = {
    "drops": (2.0, _dropped),
    "stalls": (0.0, _camera(Camera.LOST)),
    "unplugged": (1.0, _camera(Camera.LOST)),
    "another device": (1.0, _camera(Camera.LOST)),
    "black": (1.0, bad),
    "no depth": (1.0, bad),
    "time ahead": (1.0, bad),
    "time back": (1.0, bad),
    "tilted": (0.0, _fit),
    "tracker dies": (1.0, _failed),
    "tracker hangs": (0.0, _failed),
    "tracker leaks": (4.0, _leaks),
    "clock stepped": (1.0, _stepped),
}
"""Least seconds that a fault lasts, and how health reports it."""
