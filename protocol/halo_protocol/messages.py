"""The messages of the wire, as frozen values.

Rule: values only. Field names and their order are those of `table.py` (a test compares them);
a docstring gives the unit or range of each field. Numbers stay plain `int` and `float`: a newer
minor version may send an unknown enumeration number, and a reader keeps it.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum


class Hand(IntEnum):
    """Which hand a pointer belongs to."""

    UNKNOWN = 0
    LEFT = 1
    RIGHT = 2


class Finger(IntEnum):
    """Which finger a pointer is."""

    THUMB = 0
    INDEX = 1
    MIDDLE = 2
    RING = 3
    LITTLE = 4


class State(IntEnum):
    """Whether a pointer is in the air or on the surface."""

    HOVER = 0
    TOUCH = 1


class Calibration(IntEnum):
    """How much of a profile the service has."""

    NONE = 0
    """No profile: frames carry no pointers."""
    PARTIAL = 1
    """Some steps are missing: pointers are less accurate than possible."""
    COMPLETE = 2


class Source(IntEnum):
    """Where the pointers come from."""

    CAMERA = 0
    RECORDING = 1
    VIRTUAL = 2


class Tracker(IntEnum):
    """What the hand tracker is doing."""

    OFF = 0
    STARTING = 1
    SEARCHING = 2
    """Running, no hand found."""
    TRACKING = 3
    FAILED = 4


class Camera(IntEnum):
    """What the source of frames is doing."""

    STARTING = 0
    RUNNING = 1
    LOST = 2
    """Unplugged or silent; the service tries to reopen it."""
    ENDED = 3
    """A recording reached its end."""


class Load(IntEnum):
    """What the service leaves out because the machine is busy."""

    NONE = 0
    REDUCED = 1
    """The hand model gets at most ten images a second."""
    LEAST = 2
    """The hand model gets at most five images a second."""
    DROPPING = 3
    """Likewise, and camera frames were left out in the last second, which `drops` counts."""


class ProfileFit(IntEnum):
    """Whether the calibration still fits what the camera shows."""

    UNKNOWN = 0
    """No profile, or not checked yet."""
    GOOD = 1
    MOVED = 2
    """The surface is nearer or farther than when it was calibrated."""
    TILTED = 3
    """Camera or table is tilted."""
    HIDDEN = 4
    """Most of the calibrated background is not there: covered, or another place."""
    MARKER = 5
    """The printed marker is at another place."""


@dataclass(frozen=True, slots=True)
class Frame:
    """The header of a frame."""

    node: str
    """Name of the service that sends, `[a-z0-9_-]{1,32}`."""
    session: str
    """Name of this run of the service, `[g-z][a-z0-9_-]{0,31}`; new at every start."""
    frame: int
    """Counts up by 1 modulo 2^24; exact in a float32."""
    time_s: int
    """Whole seconds of the frame's time: Unix time when live, the file's own time in replay."""
    time_frac_us: int
    """Microseconds within the second, 0 to 999999."""
    count: int
    """Pointers of the whole frame, over all of its datagrams."""
    session_ms: int = 0
    """Milliseconds since the session's first frame, modulo 2^24; exact in a float32."""

    @property
    def time_us(self) -> int:
        """The frame's time in one number, microseconds."""
        return self.time_s * 1_000_000 + self.time_frac_us


@dataclass(frozen=True, slots=True)
class Pointer:
    """One fingertip above or on the surface, at the frame's time."""

    id: int
    """Grows; not reused within a session."""
    slot: int
    """The lowest free number; 0 to 9 from this service."""
    hand: int
    """A `Hand`."""
    finger: int
    """A `Finger`."""
    state: int
    """A `State`."""
    u: float
    """x over the surface's width; 0 left, 1 right, not clamped."""
    v: float
    """y over the surface's height; 0 far edge, 1 near edge, not clamped."""
    x_mm: float
    """On the surface, from its top left corner as the user sees it, to the right."""
    y_mm: float
    """The same, towards the user."""
    hover_mm: float
    """Height of the pad above the surface; 0 in touch."""
    pressure: float
    """0 in hover; in touch at least 0.02, 1 at the calibrated medium press, more beyond."""
    vx_mm_s: float
    """Velocity on the surface, to the right."""
    vy_mm_s: float
    """The same, towards the user."""
    confidence: float
    """0 to 1."""
    contacts: int
    """Number of touches that this pointer has begun."""
    force_g: float
    """Grams; -1 if the force is unknown."""

    @property
    def touching(self) -> bool:
        """Whether the pointer is on the surface."""
        return self.state == State.TOUCH


@dataclass(frozen=True, slots=True)
class Alive:
    """The full list of the live pointers of a frame."""

    ids: tuple[int, ...]
    """The `id` of each live pointer, over all datagrams of the frame."""


@dataclass(frozen=True, slots=True)
class Down:
    """A touch began; `contacts` identifies its three copies."""

    id: int
    """The pointer's."""
    slot: int
    """The pointer's."""
    u: float
    """Position of the event, over the surface's width."""
    v: float
    """The same, over its height."""
    strike_mm_s: float
    """Approach speed before contact; -1 if unknown."""
    ago_ms: float
    """Time of the event before the frame's time."""
    contacts: int
    """The pointer's `contacts` with this touch."""


@dataclass(frozen=True, slots=True)
class Up:
    """A touch ended; sent three times, too."""

    id: int
    """The pointer's."""
    slot: int
    """The pointer's."""
    u: float
    """Position of the event, over the surface's width."""
    v: float
    """The same, over its height."""
    ago_ms: float
    """Time of the event before the frame's time."""
    contacts: int
    """The number of the touch that ended."""


@dataclass(frozen=True, slots=True)
class Scene:
    """Properties of the surface and the service."""

    node: str
    """As in the frame's header."""
    session: str
    """As in the frame's header."""
    version: str
    """The protocol's version, `major.minor.patch`."""
    width_mm: float
    """The surface's size, left to right."""
    height_mm: float
    """The same, far edge to near edge."""
    calibration: int
    """A `Calibration`."""
    revision: int
    """Number of changes of surface, homography and pose in this session."""
    source: int
    """A `Source`."""
    rate_hz: float
    """Nominal frames per second of the source; 0 if it has none."""
    control_port: int = 0
    """UDP port of the service for messages from clients; 0 if it has none."""
    collision: int = 0
    """1 if another service with the same node name was found, else 0."""
    calibrated_s: int = 0
    """Unix time of the newest step of the calibration; 0 if unknown."""
    service_version: str = ""
    """Version of the program that sends, `[0-9A-Za-z.+_-]{0,32}`; empty if unknown."""
    zenoh_version: str = ""
    """Version of its Zenoh, in the same form; empty without Zenoh."""


@dataclass(frozen=True, slots=True)
class Homography:
    """Maps the surface to projector pixels."""

    node: str
    """As in the frame's header."""
    session: str
    """As in the frame's header."""
    revision: int
    """The scene's `revision` that it belongs to."""
    width_px: int
    """Width of the projector image."""
    height_px: int
    """Its height."""
    projector_from_surface: tuple[float, ...]
    """9 floats, row by row: surface mm -> projector pixels, (0, 0) at the corner of the first."""


@dataclass(frozen=True, slots=True)
class Pose:
    """Poses of the camera and of a printed marker."""

    node: str
    """As in the frame's header."""
    session: str
    """As in the frame's header."""
    revision: int
    """The scene's `revision` that it belongs to."""
    camera_from_surface: tuple[float, ...]
    """12 floats, 3x4 row by row, mm: p_camera = M p_surface; the depth camera's frame."""
    anchor_from_surface: tuple[float, ...]
    """The same for the printed marker; 12 zeros if `anchored` is 0."""
    anchored: int = 1
    """1 if `anchor_from_surface` is known, else 0."""


@dataclass(frozen=True, slots=True)
class Health:
    """State of the service over the last second."""

    node: str
    """As in the frame's header."""
    session: str
    """As in the frame's header."""
    fps: float
    """Processed frames per second."""
    latency_ms: float
    """Median from frame received to packet sent; -1 if unknown."""
    drops: int
    """Camera frames that the service did not process, in this session."""
    bad_frames: int
    """Invalid frames (no depth, all zero, a jump in time), in this session."""
    tracker: int
    """A `Tracker`."""
    camera: int
    """A `Camera`."""
    tracker_ms: float = -1.0
    """Median age of the hand tracker's result at a frame; -1 if unknown."""
    clock_jumps: int = 0
    """How often the host's clock was set (by more than 0.1 s), in this session."""
    clock_error_ms: float = 0.0
    """Host's Unix time minus the time in frames, which approaches it by 0.5 ms per second."""
    profile_fit: int = 0
    """A `ProfileFit`."""
    zenoh_missing: int = 0
    """Routers and peers of `[zenoh] connect` to which there is no connection now."""
    write_errors: int = 0
    """Profiles that could not be written (disk full), in this session."""
    memory_mb: int = -1
    """Memory of the service's process in MB; -1 if unknown."""
    load: int = 0
    """How much work is left out because the machine is busy: a `Load`."""
    looks_hz: float = -1.0
    """Images per second at which the hand model looked; -1 if unknown."""
    time_s: int = 0
    """When it was sent, by the clock of the frames' time; 0 if unknown."""
    time_frac_us: int = 0
    """Microseconds within the second, 0 to 999999."""
    nodes: int = 0
    """Surfaces of other services that a canvas merges now; 0 if it is none."""
    clock_offset_ms: float = 0.0
    """Of a canvas: how far a node's clock is behind its own, for the node that is off most."""
    clock_deviation_ms: float = -1.0
    """Error of that, apart from the shortest time on the way: median distance of the delays from
    the line below them; -1 if unknown."""


Message = Frame | Pointer | Alive | Down | Up | Scene | Homography | Pose | Health
