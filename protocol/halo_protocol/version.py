"""The protocol's version, and which versions understand each other.

Rule: this number is the protocol's; the packages' versions are other numbers.
"""

from __future__ import annotations

import re
from typing import Literal

from halo_protocol.errors import ProtocolError

VERSION = "1.0.0"

Verdict = Literal["accepted", "warned", "refused"]

_VERSION = re.compile(r"(\d{1,4})\.(\d{1,4})\.(\d{1,4})", re.ASCII)


def parse_version(text: str) -> tuple[int, int, int]:
    """`"1.2.3"` -> `(1, 2, 3)`; `ProtocolError` where it is anything else."""
    match = _VERSION.fullmatch(text)
    if match is None:
        raise ProtocolError(f"version must be major.minor.patch, not {text[:40]!r}")
    major, minor, patch = match.groups()
    return int(major), int(minor), int(patch)


def verdict(service: str, client: str) -> Verdict:
    """What a service of one version says to a client of another.

    Another major is refused. A client whose minor is older misses what was appended since: it
    is accepted, and warned. One whose minor is newer expects what this service cannot send:
    it is refused. The patch says nothing about the wire.
    """
    service_major, service_minor, _ = parse_version(service)
    client_major, client_minor, _ = parse_version(client)
    if client_major != service_major or client_minor > service_minor:
        return "refused"
    return "warned" if client_minor < service_minor else "accepted"
