"""Where frames come from: a live camera, a recording, the virtual sensor.

Rule: a source owns its device and its clock, and nothing else. It returns each capture as it was
captured, or a `BadFrame` with the reason.
"""

from __future__ import annotations

from typing import Protocol, runtime_checkable

from halo_service.errors import SourceLost
from halo_service.geometry.camera import Camera
from halo_service.values import BadFrame, Frame, SourceKind

__all__ = ["ColourSwitch", "EndOfSource", "Exposing", "Source", "SourceLost", "Warm"]


class EndOfSource(Exception):  # noqa: N818 - an end, no error
    """A recording has ended: a normal end, and the last result of `read`."""


class Source(Protocol):
    """A depth camera or a substitute. Used from one thread at a time."""

    @property
    def kind(self) -> SourceKind:
        """Where the frames come from."""

    @property
    def camera(self) -> Camera:
        """The lenses of the current mode; they do not change while the source is open."""

    def read(self, timeout_s: float) -> Frame | BadFrame | None:
        """Wait at most `timeout_s` for the next capture; None: nothing came in that time.

        Raises SourceLost, EndOfSource, or UserError if the rest cannot be read.
        """

    def close(self) -> None:
        """Close the device. May be called twice."""


@runtime_checkable
class Exposing(Protocol):
    """A source with a colour camera that has a settable exposure."""

    def expose(self, exposure_ms: float | None) -> None:
        """Set the exposure from the next frames on; None: automatic.

        Raises SourceLost.
        """


@runtime_checkable
class ColourSwitch(Protocol):
    """A source that saves work while no part of the program needs its colour."""

    def with_colour(self, wanted: bool) -> None:
        """Switch colour on or off, soon; frames without it have None. Raises SourceLost."""


@runtime_checkable
class Warm(Protocol):
    """A source that can report its temperature."""

    def temperature_c(self) -> float | None:
        """Return the temperature of the depth sensor, degrees Celsius; None: not reported."""
