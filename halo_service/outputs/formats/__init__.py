"""How touches are written for a destination: `frames`, `flat`, `tuio11`, `tuio2`.

Rule: pure; messages in, datagrams out. A format may remember what it sent, nothing else.
"""

from __future__ import annotations

from typing import Protocol

from halo_service.outputs.destination import Stream
from halo_service.outputs.formats.flat import FlatFormat
from halo_service.outputs.formats.frames import FramesFormat
from halo_service.outputs.formats.tuio2 import Tuio2Format
from halo_service.outputs.formats.tuio11 import Tuio11Format
from halo_service.outputs.outgoing import OutgoingFrame, OutgoingReport


class Format(Protocol):
    """One way to write frames and reports."""

    def frame(self, frame: OutgoingFrame) -> list[bytes]:
        """Return the datagrams of a frame."""

    def report(self, report: OutgoingReport) -> list[bytes]:
        """Return the datagrams of a report; empty where the format has no place for it."""


def make_format(stream: Stream) -> Format:
    """Return a new format for a stream."""
    if stream.format == "flat":
        return FlatFormat(bundles=stream.bundles, changes=stream.changes)
    if stream.format == "tuio11":
        return Tuio11Format()
    if stream.format == "tuio2":
        return Tuio2Format()
    return FramesFormat(bundles=stream.bundles, timetagged=stream.timetags)
