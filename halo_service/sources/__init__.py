"""Where frames come from: a live Kinect, a recording, the virtual sensor.

Rule: a source owns its device and its clock, and nothing else. It hands over what was
captured, as it was captured; what it cannot hand over it names (`BadFrame`).
"""

from __future__ import annotations

from typing import Protocol, runtime_checkable

from halo_service.errors import SourceLost
from halo_service.geometry.camera import Camera
from halo_service.values import BadFrame, Frame, SourceKind

__all__ = ["EndOfSource", "Exposing", "Source", "SourceLost"]


class EndOfSource(Exception):  # noqa: N818 - an end, no error
    """A recording has ended: a normal end, and the last thing `read` says."""


class Source(Protocol):
    """A depth camera, or something that stands in for one. Used from one thread at a time."""

    @property
    def kind(self) -> SourceKind:
        """What stands behind the frames."""

    @property
    def camera(self) -> Camera:
        """The lenses of the mode that the frames come in; the same as long as it is open."""

    def read(self, timeout_s: float) -> Frame | BadFrame | None:
        """Wait at most `timeout_s` for the next capture; None: nothing came in that time.

        Raises SourceLost, EndOfSource, or UserError where the rest cannot be read.
        """

    def close(self) -> None:
        """Let the device go. May be called twice."""


@runtime_checkable
class Exposing(Protocol):
    """A source whose colour camera can be told how long to expose."""

    def expose(self, exposure_ms: float | None) -> None:
        """Expose for so long from the next frames on; None: as the camera thinks best.

        Raises SourceLost.
        """
