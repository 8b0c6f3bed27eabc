"""What the service sends: a frame or a report, as messages and, once needed, as bytes or text.

Rule: values only. Each output takes the form that it needs; bytes and text are encoded once,
however many clients there are.
"""

from __future__ import annotations

import json
from dataclasses import dataclass
from functools import cached_property
from typing import Any, ClassVar

import halo_protocol as wire

Reported = wire.Scene | wire.Homography | wire.Pose | wire.Health


@dataclass(frozen=True)
class OutgoingFrame:
    """One frame of one surface."""

    surface: str
    size_mm: tuple[float, float]
    """Width and height of the surface."""
    header: wire.Frame
    pointers: tuple[wire.Pointer, ...]
    downs: tuple[wire.Down, ...]
    """New and repeated ones."""
    ups: tuple[wire.Up, ...]
    max_bytes: int = wire.MAX_BUNDLE
    named_only: bool = False
    """A copy for those who name its surface: others would have each finger twice."""
    kind: ClassVar[str] = "frame"

    @cached_property
    def datagrams(self) -> list[bytes]:
        """The frame in the `frames` format."""
        return self.encoded()

    @cached_property
    def text(self) -> str:
        """The frame as JSON: the header's fields, `time_us`, `pointers` and `events`.

        An event comes in three frames with the same `contacts`, as on the wire.
        """
        return _json_text(
            self,
            {
                **wire.to_json(self.header),
                "time_us": self.header.time_us,
                "pointers": [wire.to_json(each) for each in self.pointers],
                "events": [
                    *({"kind": "down", **wire.to_json(each)} for each in self.downs),
                    *({"kind": "up", **wire.to_json(each)} for each in self.ups),
                ],
            },
        )

    def encoded(self, *, timetagged: bool = False) -> list[bytes]:
        """Encode it, optionally with its time as timetag."""
        return wire.encode_frame(
            self.surface,
            self.header,
            self.pointers,
            self.downs,
            self.ups,
            max_bytes=self.max_bytes,
            timetagged=timetagged,
        )


@dataclass(frozen=True)
class OutgoingReport:
    """A scene, homography, pose or health message."""

    surface: str
    message: Reported
    named_only: bool = False
    """As of a frame."""

    @property
    def kind(self) -> str:
        """Last part of the address and of the Zenoh key."""
        return type(self.message).__name__.lower()

    @cached_property
    def datagrams(self) -> list[bytes]:
        """The message in the `frames` format."""
        return [wire.encode(self.surface, self.message)]

    @cached_property
    def text(self) -> str:
        """The message as JSON."""
        return _json_text(self, wire.to_json(self.message))


Outgoing = OutgoingFrame | OutgoingReport


def _json_text(outgoing: Outgoing, view: dict[str, Any]) -> str:
    """Return one line of JSON with the message's `kind` and `surface`."""
    view = {"kind": outgoing.kind, "surface": outgoing.surface, **view}
    return json.dumps(view, separators=(",", ":"), allow_nan=False)
