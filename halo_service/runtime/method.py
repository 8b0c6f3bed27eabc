"""A method: one way to turn frames into touches. Ours is one; the evaluation runs others too.

Rule: a method is pure, as the sensing is: all that it remembers of earlier frames is in its state.
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
"""What a method remembers; no other code looks inside."""

Seen = Iterable[tuple[Frame, Tracked]]
"""Frames, each with the hands that the tracker found in the same frame."""
Script = Sequence[Mapping[str, Any]]
"""Which calibration step happens when, as `halo calibrate --script` reads it."""


@dataclass(frozen=True, slots=True)
class Method(Generic[State]):
    """Frames in, touches out; every method publishes the same kind of frame."""

    name: str
    start: Callable[[Profile | None, SensingSettings], State]
    """The state before the first frame."""
    step: Callable[[State, Frame, Tracked | None], tuple[TouchFrame, State]]
    """Sense one frame, with the newest hands that the tracker has."""
    clear: Callable[[State, int], tuple[TouchFrame, State]]
    """Release all pointers, at a time in microseconds: for a frame that cannot be sensed."""
    learn: Callable[[Profile, SensingSettings, Seen, Script], Profile] | None = None
    """Calibrate with this method's own signal: from the profile that `halo calibrate` wrote and
    the whole recording behind it; raises `UserError` if this signal cannot be calibrated.
    None: the method uses the profile as it is."""
    whole_image: bool = False
    """Whether its hand tracker sees the whole blended image, as in the paper, or the regions that
    depth proposes, as ours does."""
    paced: bool = False
    """Whether its hand tracker leaves out frames in which depth confirms the hands; it then
    follows fingers between two looks by itself."""


OURS = Method("ours", sensing.start, sensing.step, sensing.clear, paced=True)
