"""The table: the wire format, one row per message.

Rule: reading and writing are derived from these rows only. A field is `name:type`; the types
are OSC's `i` (int32), `f` (float32) and `s` (string), because some clients lose every argument
after another type. `f9` is nine in a row, `i*` any number. ` | ` ends the fields of 1.0: a later
minor version appends after it. A message of an older one ends before these fields, and they have
the defaults of their class.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import groupby
from operator import attrgetter
from struct import Struct
from typing import Any

from halo_protocol import messages

FRAME = (
    "node:s session:s frame:i time_s:i time_frac_us:i count:i session_ms:i"  # append; never reorder
)
POINTER = (
    "id:i slot:i hand:i finger:i state:i u:f v:f x_mm:f y_mm:f hover_mm:f pressure:f "
    "vx_mm_s:f vy_mm_s:f confidence:f contacts:i force_g:f"  # append; never reorder
)
ALIVE = "ids:i*"  # complete as it is: nothing can be appended to an open list
DOWN = "id:i slot:i u:f v:f strike_mm_s:f ago_ms:f contacts:i"  # append; never reorder
UP = "id:i slot:i u:f v:f ago_ms:f contacts:i"  # append; never reorder
SCENE = (
    "node:s session:s version:s width_mm:f height_mm:f "
    "calibration:i revision:i source:i rate_hz:f "
    "control_port:i collision:i calibrated_s:i "
    "service_version:s zenoh_version:s"  # append; never reorder
)
HOMOGRAPHY = (
    "node:s session:s revision:i width_px:i height_px:i "
    "projector_from_surface:f9"  # append; never reorder
)
POSE = (
    "node:s session:s revision:i "
    "camera_from_surface:f12 anchor_from_surface:f12 anchored:i"  # append; never reorder
)
HEALTH = (
    "node:s session:s fps:f latency_ms:f drops:i bad_frames:i "
    "tracker:i camera:i tracker_ms:f clock_jumps:i clock_error_ms:f "
    "profile_fit:i zenoh_missing:i write_errors:i memory_mb:i "
    "load:i looks_hz:f time_s:i time_frac_us:i nodes:i "
    "clock_offset_ms:f clock_deviation_ms:f"  # append; never reorder
)


@dataclass(frozen=True, slots=True)
class Field:
    """One field of a row."""

    name: str
    tag: str
    """`i`, `f` or `s`."""
    length: int | None
    """Number of arguments; None for any number, which is allowed for the last field only."""


@dataclass(frozen=True, slots=True)
class Run:
    """Neighbouring arguments for one `struct`; a string is a run of its own."""

    numbers: Struct | None
    """None for a string."""
    count: int


@dataclass(frozen=True, slots=True)
class Row:
    """A message: its name in the address, its class and its compiled fields."""

    kind: str
    message: Callable[..., messages.Message]
    when: str
    """When a service sends it, for the specification."""
    fields: tuple[Field, ...]
    required: int
    """Number of fields that each message has: those of 1.0."""
    older: tuple[Row, ...]
    """This row with fewer fields, from 1.0 on, as older minor versions send it."""
    tags: str
    """The OSC type tags of all fields of a fixed length, without the comma."""
    runs: tuple[Run, ...]
    open_list: bool
    """Whether the row has one field of any length."""
    plain: bool
    """Whether each field has one argument."""
    fetch: Callable[[Any], tuple[Any, ...]]
    """Message -> its fields' values."""

    @classmethod
    def of(cls, kind: str, message: Callable[..., messages.Message], text: str, when: str) -> Row:
        """Compile one line of the table."""
        words = text.replace("|", "").split()
        required = len(text.partition("|")[0].split())
        fields = tuple(map(_field, words))
        tags = "".join(field.tag * (field.length or 0) for field in fields)
        names = [field.name for field in fields]
        fetch = attrgetter(*names)
        return cls(
            kind=kind,
            message=message,
            when=when,
            fields=fields,
            required=required,
            older=tuple(
                cls.of(kind, message, " ".join(words[:count]), when)
                for count in range(required, len(words))
            ),
            tags=tags,
            runs=tuple(_runs(tags)),
            open_list=fields[-1].length is None,
            plain=all(field.length == 1 for field in fields),
            # attrgetter of one name returns the bare value.
            fetch=fetch if len(names) > 1 else lambda message: (fetch(message),),
        )


def _field(text: str) -> Field:
    name, _, kind = text.partition(":")
    tag, length = kind[0], kind[1:]
    return Field(name, tag, None if length == "*" else int(length or 1))


def _runs(tags: str) -> list[Run]:
    runs: list[Run] = []
    for is_string, group in groupby(tags, lambda tag: tag == "s"):
        run = "".join(group)
        runs += [Run(None, 1)] * len(run) if is_string else [Run(Struct(f">{run}"), len(run))]
    return runs


ROWS = (
    Row.of("frame", messages.Frame, FRAME, "first in each datagram of a frame"),
    Row.of("pointer", messages.Pointer, POINTER, "once for each live pointer"),
    Row.of("alive", messages.Alive, ALIVE, "last in each datagram of a frame, the full list"),
    Row.of("down", messages.Down, DOWN, "in the frame of the touch and in the next two"),
    Row.of("up", messages.Up, UP, "in the frame of the release and in the next two"),
    Row.of("scene", messages.Scene, SCENE, "on change and twice a second"),
    Row.of(
        "homography",
        messages.Homography,
        HOMOGRAPHY,
        "on change and twice a second, if known",
    ),
    Row.of(
        "pose", messages.Pose, POSE, "on change and twice a second, if the camera pose is known"
    ),
    Row.of("health", messages.Health, HEALTH, "once a second"),
)

ROW_OF_KIND = {row.kind: row for row in ROWS}
ROW_OF_MESSAGE: dict[Any, Row] = {row.message: row for row in ROWS}
