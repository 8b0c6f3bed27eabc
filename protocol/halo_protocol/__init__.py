"""The halo protocol: touch, hover and pressure as OSC bundles.

Rule: pure. No I/O, no clock, no dependencies; bytes and times are arguments. `SPEC.md` in the
folder above is the specification.
"""

from halo_protocol.assembly import Assembler
from halo_protocol.checks import MAX_EVENTS, MAX_POINTERS
from halo_protocol.codec import MAX_BUNDLE, decode, encode, encode_frame
from halo_protocol.counter import ahead, first_frame, is_newer, next_frame, session_ms
from halo_protocol.errors import ProtocolError
from halo_protocol.events import Collision, Event, Lost, Report, TouchFrame
from halo_protocol.jsonview import event_to_json, from_json, to_json
from halo_protocol.messages import (
    Alive,
    Calibration,
    Camera,
    Down,
    Finger,
    Frame,
    Hand,
    Health,
    Homography,
    Load,
    Message,
    Pointer,
    Pose,
    ProfileFit,
    Scene,
    Source,
    State,
    Tracker,
    Up,
)
from halo_protocol.names import (
    ANY,
    DEFAULT_SURFACE,
    RESERVED_SURFACES,
    ZENOH_KINDS,
    address,
    check_name,
    check_session,
    check_surface,
    liveliness_key,
    zenoh_key,
)
from halo_protocol.osc import Argument, parse_osc
from halo_protocol.ports import DEFAULT_CONTROL_PORT, DEFAULT_PORT
from halo_protocol.touch_counter import UNKNOWN_STRIKE
from halo_protocol.version import VERSION, Verdict, verdict

__all__ = [
    "ANY",
    "DEFAULT_CONTROL_PORT",
    "DEFAULT_PORT",
    "DEFAULT_SURFACE",
    "MAX_BUNDLE",
    "MAX_EVENTS",
    "MAX_POINTERS",
    "RESERVED_SURFACES",
    "UNKNOWN_STRIKE",
    "VERSION",
    "ZENOH_KINDS",
    "Alive",
    "Argument",
    "Assembler",
    "Calibration",
    "Camera",
    "Collision",
    "Down",
    "Event",
    "Finger",
    "Frame",
    "Hand",
    "Health",
    "Homography",
    "Load",
    "Lost",
    "Message",
    "Pointer",
    "Pose",
    "ProfileFit",
    "ProtocolError",
    "Report",
    "Scene",
    "Source",
    "State",
    "TouchFrame",
    "Tracker",
    "Up",
    "Verdict",
    "address",
    "ahead",
    "check_name",
    "check_session",
    "check_surface",
    "decode",
    "encode",
    "encode_frame",
    "event_to_json",
    "first_frame",
    "from_json",
    "is_newer",
    "liveliness_key",
    "next_frame",
    "parse_osc",
    "session_ms",
    "to_json",
    "verdict",
    "zenoh_key",
]
