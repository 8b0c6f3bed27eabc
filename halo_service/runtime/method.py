"""A method: one way of making touches of frames. Ours is one; the bench runs rivals beside it.

Rule: a method is pure, as the sensing is: what it knows of earlier frames is in its state.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Generic, TypeVar

from halo_service import sensing
from halo_service.profile import Profile
from halo_service.sensing import SensingSettings
from halo_service.values import Frame, TouchFrame, Tracked

State = TypeVar("State")
"""Whatever a method remembers; nobody else looks inside."""

Seen = Iterable[tuple[Frame, Tracked]]
"""Frames, each with what the hand tracker saw in that very frame."""
Script = Sequence[Mapping[str, Any]]
"""Which calibration step happens when, as `halo calibrate --script` reads it."""


@dataclass(frozen=True, slots=True)
class Method(Generic[State]):
    """Frames in, touches out; every method publishes the same kind of frame."""

    name: str
    start: Callable[[Profile | None, SensingSettings], State]
    """The state before the first frame."""
    step: Callable[[State, Frame, Tracked | None], tuple[TouchFrame, State]]
    """One frame, with the newest that the hand tracker has."""
    clear: Callable[[State, int], tuple[TouchFrame, State]]
    """Let all pointers go, at a time in microseconds: a frame that cannot be sensed."""
    learn: Callable[[Profile, SensingSettings, Seen, Script], Profile] | None = None
    """Calibrate anew with this method's own signal: the profile as `halo calibrate` made it, and
    the whole take that it was made of; raises `UserError` where this signal cannot be calibrated.
    None: the method reads the profile as it is."""


OURS = Method("ours", sensing.start, sensing.step, sensing.clear)
