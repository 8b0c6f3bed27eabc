"""The protocol version, and which versions work together.

Rule: this is the version of the protocol; packages have their own.
"""

from __future__ import annotations

import re
from typing import Literal

from halo_protocol.errors import ProtocolError

VERSION = "1.0.0"

RELEASED: tuple[str, ...] = ()
"""Released minor versions, such as "1.0": their vectors never change."""

Verdict = Literal["accepted", "warned", "refused"]

_PROGRAM_VERSION = re.compile(r"[0-9A-Za-z.+_-]{0,32}", re.ASCII)
_VERSION = re.compile(r"(\d{1,4})\.(\d{1,4})\.(\d{1,4})", re.ASCII)


def parse_version(text: str) -> tuple[int, int, int]:
    """`"1.2.3"` -> `(1, 2, 3)`; `ProtocolError` for anything else."""
    match = _VERSION.fullmatch(text)
    if match is None:
        raise ProtocolError(f"version must be major.minor.patch, not {text[:40]!r}")
    major, minor, patch = match.groups()
    return int(major), int(minor), int(patch)


def check_program_version(text: str, what: str) -> str:
    """Return the version of a program, which has no control characters; else `ProtocolError`."""
    if _PROGRAM_VERSION.fullmatch(text) is None:
        raise ProtocolError(f"{what} must match [0-9A-Za-z.+_-]{{0,32}}, not {text[:40]!r}")
    return text


def verdict(service: str, client: str) -> Verdict:
    """How a service of one version answers a client of another.

    Another major is refused. A client with an older minor does not know what was appended
    since: it is accepted with a warning. A client with a newer minor expects data that this
    service does not send: it is refused. The patch does not affect the wire.
    """
    service_major, service_minor, _ = parse_version(service)
    client_major, client_minor, _ = parse_version(client)
    if client_major != service_major or client_minor > service_minor:
        return "refused"
    return "warned" if client_minor < service_minor else "accepted"
