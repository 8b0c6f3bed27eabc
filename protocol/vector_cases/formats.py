"""Frames in the formats for programs that do not read frames, and as JSON text.

Rule: only this table needs the service, which writes these formats; a reader needs the files alone.
"""

from __future__ import annotations

from halo_service.outputs.destination import parse_destination
from halo_service.outputs.formats import make_format
from halo_service.outputs.outgoing import OutgoingFrame
from vector_cases.build import FrameCase
from vector_cases.writing import FRAMES

SIZE_MM = (300.0, 200.0)
STREAMS = ("flat", "flat,bundles=off", "tuio11", "tuio2")
"""Formats with their options, as a user writes them."""
SHOWN = (
    "empty",
    "hovering",
    "touch-begins",
    "last-finger-left",
    "ten-fingers",
    "off-the-surface",
)
"""Frames of `frames.json`."""
FORMATS = [case for case in FRAMES if case.name in SHOWN]


def outgoing(case: FrameCase) -> OutgoingFrame:
    """The frame as the service's outputs get it."""
    return OutgoingFrame(
        case.surface, SIZE_MM, case.header, tuple(case.pointers), tuple(case.downs), tuple(case.ups)
    )


def datagrams(case: FrameCase, stream: str) -> list[bytes]:
    """The first frame of a stream."""
    destination = parse_destination(f"127.0.0.1:1/{stream}")
    return make_format(destination.stream).frame(outgoing(case))
