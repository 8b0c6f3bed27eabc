"""Validity of messages beyond their types, checked when writing and when reading.

Rule: check only what a reader relies on (names used as keys, counts used for allocation, sizes
used as divisors). Enumeration numbers are not checked: a newer minor version may add one.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from halo_protocol.counter import MODULUS
from halo_protocol.errors import ProtocolError
from halo_protocol.messages import (
    Alive,
    Down,
    Frame,
    Health,
    Homography,
    Pointer,
    Pose,
    Scene,
    Up,
)
from halo_protocol.names import check_name, check_session
from halo_protocol.version import check_program_version, parse_version

MAX_POINTERS = 64
"""Fingers of six people; the alive list still leaves room in each datagram."""
MAX_EVENTS = 256
"""Downs and ups of one frame: those of 64 pointers, and repeated ones."""


def _require(condition: bool, sentence: str) -> None:
    if not condition:
        raise ProtocolError(sentence)


def _sender(message: Frame | Scene | Homography | Pose | Health) -> None:
    check_name(message.node, "node")
    check_session(message.session)


def _time(message: Frame | Health) -> None:
    _require(message.time_s >= 0, f"time_s must not be negative: {message.time_s}")
    fraction = message.time_frac_us
    _require(0 <= fraction < 1_000_000, f"time_frac_us must be 0 to 999999, not {fraction}")


def _frame(message: Frame) -> None:
    _sender(message)
    _require(0 <= message.frame < MODULUS, f"frame must be 0 to 2^24 - 1, not {message.frame}")
    _time(message)
    ms = message.session_ms
    _require(0 <= ms < MODULUS, f"session_ms must be 0 to 2^24 - 1, not {ms}")
    count = message.count
    _require(0 <= count <= MAX_POINTERS, f"count must be 0 to {MAX_POINTERS}, not {count}")


def _counted(message: Pointer | Down | Up) -> None:
    if message.id < 0 or message.slot < 0 or message.contacts < 0:
        raise ProtocolError(
            f"id, slot and contacts must not be negative: "
            f"{message.id}, {message.slot}, {message.contacts}"
        )


def _alive(message: Alive) -> None:
    ids = message.ids
    _require(
        len(ids) <= MAX_POINTERS, f"at most {MAX_POINTERS} pointers can be alive, not {len(ids)}"
    )
    _require(len(set(ids)) == len(ids), "the alive list has an id twice")


def _scene(message: Scene) -> None:
    _sender(message)
    parse_version(message.version)
    size = f"{message.width_mm} x {message.height_mm}"
    _require(message.collision in (0, 1), f"collision must be 0 or 1, not {message.collision}")
    port = message.control_port
    _require(0 <= port < 2**16, f"control_port must be 0 to 65535, not {port}")
    calibrated_s = message.calibrated_s
    _require(calibrated_s >= 0, f"calibrated_s must be 0 or more, not {calibrated_s}")
    check_program_version(message.service_version, "service_version")
    check_program_version(message.zenoh_version, "zenoh_version")
    _require(
        message.width_mm > 0 and message.height_mm > 0,
        f"the size of a surface must be positive, not {size}",
    )


def _health(message: Health) -> None:
    _sender(message)
    _time(message)


def _homography(message: Homography) -> None:
    _sender(message)
    size = f"{message.width_px} x {message.height_px}"
    _require(
        message.width_px > 0 and message.height_px > 0,
        f"the size of a projector image must be positive, not {size}",
    )


def _pose(message: Pose) -> None:
    _sender(message)
    _require(message.anchored in (0, 1), f"anchored must be 0 or 1, not {message.anchored}")


CHECKS: dict[Any, Callable[[Any], None]] = {
    Frame: _frame,
    Pointer: _counted,
    Alive: _alive,
    Down: _counted,
    Up: _counted,
    Scene: _scene,
    Homography: _homography,
    Pose: _pose,
    Health: _health,
}
"""Message class -> check that raises `ProtocolError` for an invalid message."""
