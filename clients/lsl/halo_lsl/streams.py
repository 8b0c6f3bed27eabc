"""The streams: their channels and their description, as the XDF community writes it.

Rule: values and pure functions. Element names are those of XDF's meta-data pages: `channels`,
`acquisition`, `synchronization`, `setup`.
"""

from __future__ import annotations

from dataclasses import dataclass
from datetime import UTC, datetime
from typing import Any

from halo_lsl.clock import Kind
from halo_protocol import Calibration, Scene
from halo_protocol import Source as SourceKind

SLOTS = 10
"""Fingers that have channels; the service gives each finger the lowest free slot, 0 to 9."""
IRREGULAR = 0.0


@dataclass(frozen=True, slots=True)
class Channel:
    """A channel and its words."""

    label: str
    unit: str
    type: str


@dataclass(frozen=True, slots=True)
class Stream:
    """A row of the table."""

    name: str
    type: str
    """Content type of LSL: `MoCap` and `Markers` are XDF's own."""
    channels: tuple[Channel, ...]
    regular: bool
    text: bool = False
    """Whether the channel is a string; else all are 32-bit floats."""


# fmt: off
FINGER = (
    Channel("id",         "none",        "ID"),
    Channel("hand",       "none",        "Hand"),
    Channel("finger",     "none",        "Finger"),
    Channel("touch",      "bool",        "Touch"),
    Channel("x",          "millimeters", "PositionX"),
    Channel("y",          "millimeters", "PositionY"),
    Channel("hover",      "millimeters", "PositionZ"),
    Channel("pressure",   "normalized",  "Pressure"),
    Channel("force",      "grams",       "Force"),
    Channel("vx",         "mm/s",        "VelocityX"),
    Channel("vy",         "mm/s",        "VelocityY"),
    Channel("confidence", "normalized",  "Confidence"),
)
"""Of each finger; NaN while a slot is empty. Positions are on the surface, hover is above it."""
CONTACT = (
    Channel("touch",    "bool",        "Touch"),
    Channel("id",       "none",        "ID"),
    Channel("contacts", "none",        "Count"),
    Channel("hand",     "none",        "Hand"),
    Channel("finger",   "none",        "Finger"),
    Channel("x",        "millimeters", "PositionX"),
    Channel("y",        "millimeters", "PositionY"),
    Channel("strike",   "mm/s",        "VelocityZ"),
)
"""One sample for each touch that begins (touch 1) or ends (touch 0)."""
# fmt: on

POINTERS = Stream(
    "halo-pointers",
    "MoCap",
    (
        Channel("fingers", "none", "Count"),
        *(
            Channel(f"f{slot}_{each.label}", each.unit, each.type)
            for slot in range(SLOTS)
            for each in FINGER
        ),
    ),
    regular=True,
)
CONTACTS = Stream("halo-contacts", "Contacts", CONTACT, regular=False)
MARKERS = Stream("halo-markers", "Markers", (Channel("marker", "none", "Marker"),), False, True)
STREAMS = (POINTERS, CONTACTS, MARKERS)

Tree = dict[str, Any]
"""XML as nested dicts; a list is a repeated element."""


@dataclass(frozen=True, slots=True)
class Setup:
    """What the service has reported when the streams are created."""

    node: str
    surface: str
    scene: Scene | None
    """None: the service or the recorded stream reports none."""
    rate_hz: float
    clock: Kind
    pipeline_s: float
    """Median from exposure to arrival, over the frames before the streams were created."""
    created_s: float
    """Unix time of their creation."""


def source_id(stream: Stream, setup: Setup) -> str:
    """Return the same name after a restart, so that a recorder goes on."""
    return f"{stream.name}:{setup.node}:{setup.surface}"


def description(stream: Stream, setup: Setup) -> Tree:
    """Return the content of LSL's `desc`."""
    return {
        "channels": {
            "channel": [
                {"label": each.label, "unit": each.unit, "type": each.type}
                for each in stream.channels
            ]
        },
        "acquisition": {
            "manufacturer": "halo-service",
            "model": "halo-lsl",
            "node": setup.node,
            "surface": setup.surface,
            **_scene(setup.scene, setup.created_s),
        },
        "synchronization": {
            "time_source": f"exposure of the frame, by its Unix time ({setup.clock})",
            "offset_mean": "0",
            "can_drop_samples": "true",
            "pipeline_delay_ms": f"{1e3 * setup.pipeline_s:.1f}",
        },
    }


def _scene(scene: Scene | None, now_s: float) -> Tree:
    if scene is None:
        return {"source": "unknown", "calibration": {"state": "unknown"}}
    return {
        "source": _word(SourceKind, scene.source),
        "protocol_version": scene.version,
        "calibration": {
            "state": _word(Calibration, scene.calibration),
            "revision": str(scene.revision),
            **_age(scene, now_s),
        },
        "surface_size": {
            "width": f"{scene.width_mm:g}",
            "height": f"{scene.height_mm:g}",
            "unit": "millimeters",
        },
    }


def _age(scene: Scene, now_s: float) -> Tree:
    """Date and age of the calibration; nothing if the service does not report its date."""
    if not scene.calibrated_s:
        return {}
    date = datetime.fromtimestamp(scene.calibrated_s, UTC).isoformat().replace("+00:00", "Z")
    return {"date": date, "age_s": f"{now_s - scene.calibrated_s:.0f}"}


def _word(kind: Any, number: int) -> str:
    """The name of an enumeration's value; a newer service may have more."""
    return kind(number).name.lower() if number in set(kind) else str(number)
