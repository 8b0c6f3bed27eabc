"""Names, addresses and keys.

Rule: OSC addresses and Zenoh keys are built only here, and every name is checked here, so no
name can contain a separator or a wildcard.
"""

from __future__ import annotations

import re

from halo_protocol.errors import ProtocolError

MAJOR = 1
"""Part of every address and key: another major version is another protocol."""
ROOT = f"/halo/{MAJOR}/"
DEFAULT_SURFACE = "table"
RESERVED_SURFACES = frozenset({"control", "sim"})
"""`/halo/1/control/...` is for messages to a service, `/halo/1/sim/...` for its virtual camera."""
ANY = "*"
"""Zenoh's wildcard for one chunk of a key."""
ZENOH_KINDS = ("frame", "scene", "homography", "pose", "health")

# Lower case without dots, slashes or wildcards: safe in OSC patterns, Zenoh keys and file names.
_NAME = re.compile(r"[a-z0-9_-]{1,32}")
# Without digits, a to f and signs at the start no tool can read it as a number: 1e205678 is one.
_SESSION = re.compile(r"[g-z][a-z0-9_-]{0,31}")


def check_name(name: str, what: str) -> str:
    """Return the name of a node; `ProtocolError` if it is not `[a-z0-9_-]{1,32}`."""
    if not _NAME.fullmatch(name):
        raise ProtocolError(f"{what} must be 1 to 32 of a-z 0-9 _ -, not {name[:40]!r}")
    return name


def check_session(name: str) -> str:
    """Return the name of a session; `ProtocolError` if it is not `[g-z][a-z0-9_-]{0,31}`."""
    if not _SESSION.fullmatch(name):
        raise ProtocolError(
            f"session must be 1 to 32 of a-z 0-9 _ - and start with g to z, not {name[:40]!r}"
        )
    return name


def check_surface(name: str) -> str:
    """Return `name`; `ProtocolError` if it is not a valid surface."""
    if name in RESERVED_SURFACES:
        raise ProtocolError(f"surface {name!r} is reserved; choose another name")
    return check_name(name, "surface")


def address(surface: str, kind: str) -> str:
    """The OSC address of a message: `/halo/1/table/pointer`."""
    return f"{ROOT}{check_surface(surface)}/{kind}"


def zenoh_key(node: str, surface: str, kind: str) -> str:
    """The Zenoh key of a kind of bundle: `halo/1/desk/table/frame`; each part may be `ANY`."""
    parts = (
        node if node == ANY else check_name(node, "node"),
        surface if surface == ANY else check_surface(surface),
        kind,
    )
    if kind != ANY and kind not in ZENOH_KINDS:
        raise ProtocolError(f"Zenoh carries {', '.join(ZENOH_KINDS)}, not {kind[:40]!r}")
    return f"halo/{MAJOR}/{'/'.join(parts)}"


def liveliness_key(node: str) -> str:
    """The Zenoh key of a node's liveliness token: `halo/1/desk/alive`; the node may be `ANY`."""
    return f"halo/{MAJOR}/{node if node == ANY else check_name(node, 'node')}/alive"
