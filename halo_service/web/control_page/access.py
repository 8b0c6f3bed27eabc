"""Who may open the control page, and in which role.

Rule: pure. On the loopback the page needs no token; the host's name and the page's origin are
checked, because pages of any site can send requests to this machine. On a network each request
needs a token as well.
"""

from __future__ import annotations

import hmac
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal
from urllib.parse import urlsplit

from halo_service.web.access import LOOPBACK

Role = Literal["operator", "viewer"]
"""An operator may change things, a viewer may look."""
HEADER = "X-Halo-Page"
"""Only a page of the same origin can set it without a question that this server refuses."""


class Refused(Exception):  # noqa: N818 - an answer, no error of the program
    """Why a request is refused, with its HTTP status."""

    def __init__(self, status: int, reason: str) -> None:
        super().__init__(reason)
        self.status = status


@dataclass(frozen=True, slots=True)
class PageAccess:
    """What is allowed."""

    hosts: frozenset[str] = frozenset()
    """Names and addresses of this machine besides those of the loopback."""
    tokens: Mapping[str, Role] = field(default_factory=dict)
    """Token -> role; empty: no token is needed, as the page is on the loopback alone."""

    def role(self, host: str, token: str | None) -> Role:
        """Return the role of a request by its Host header and token. Raises `Refused`."""
        if _name(f"//{host}") not in LOOPBACK | self.hosts:
            raise Refused(403, "this server has another name; add yours to [page] hosts")
        if not self.tokens:
            return "operator"
        for known, role in self.tokens.items():
            if token is not None and hmac.compare_digest(known.encode(), token.encode()):
                return role
        raise Refused(401, "this page needs the address with its token, as 'halo serve' prints it")

    def check_origin(self, host: str, origin: str | None) -> None:
        """Check that a request comes from our own page. Raises `Refused`."""
        if origin is None or not host or origin.lower() != f"http://{host}".lower():
            raise Refused(403, "only the control page itself may send this")


def _name(url: str) -> str | None:
    try:
        return urlsplit(url).hostname
    except ValueError:
        return None
