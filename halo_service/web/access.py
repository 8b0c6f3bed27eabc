"""Which requests are answered.

Rule: pure. A web page of any site can send requests to this machine; a name server of any site can
point at it. So both the requested host and the requesting page must be allowed.
"""

from __future__ import annotations

from dataclasses import dataclass
from urllib.parse import urlsplit

LOOPBACK = frozenset({"localhost", "127.0.0.1", "::1"})


@dataclass(frozen=True, slots=True)
class Access:
    """Allowed hosts and pages."""

    hosts: frozenset[str] = frozenset()
    """Besides those of the loopback."""
    origins: frozenset[str] = frozenset()
    """Pages of other hosts."""

    def refusal(self, host: str, origin: str | None) -> str | None:
        """Return why a request is refused, or None. `host`, `origin`: its headers."""
        allowed = LOOPBACK | self.hosts
        name = _host_name(f"//{host}")
        if name not in allowed:
            return f"this server is not '{_ascii(host)}'; add the name to [web] hosts"
        if origin is None or origin in self.origins:
            return None
        if _host_name(origin) not in allowed:
            return f"pages of '{_ascii(origin)}' may not connect; add it to [web] origins"
        return None


def _ascii(header: str) -> str:
    """Return a header for a sentence; bytes that are not UTF-8 cannot be sent back."""
    return header[:80].encode("ascii", "backslashreplace").decode()


def _host_name(url: str) -> str | None:
    try:
        return urlsplit(url).hostname
    except ValueError:
        return None
