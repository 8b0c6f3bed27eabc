"""Settings of the web servers."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

from annotated_types import Interval
from pydantic import Field

DEFAULT_WEB_PORT = 4258
DEFAULT_PAGE_PORT = 8765


@dataclass(frozen=True, slots=True)
class WebSettings:
    """`[web]` in halo.toml: WebSocket for browsers."""

    enabled: bool = True
    """Listen for browsers and OSCQuery."""
    host: str = "127.0.0.1"
    """Address to listen on; 0.0.0.0 lets other machines connect."""
    port: Annotated[int, Interval(ge=1, le=65_535)] = DEFAULT_WEB_PORT
    """TCP port; a free one is used where it is in use."""
    announce: bool = True
    """Announce this server and the control port by mDNS, each where its `host` can be reached."""
    hosts: tuple[str, ...] = ()
    """Names or addresses under which other machines open this server, such as `table.local`."""
    origins: tuple[str, ...] = ()
    """Pages of other hosts that may connect, such as `https://example.org`, or `null` for files."""


@dataclass(frozen=True, slots=True)
class PageSettings:
    """`[page]` in halo.toml: the control page."""

    enabled: bool = True
    """Serve the control page."""
    host: str = "127.0.0.1"
    """Address to listen on; 0.0.0.0 lets other machines open the page, with a token alone."""
    port: Annotated[int, Interval(ge=1, le=65_535)] = DEFAULT_PAGE_PORT
    """TCP port; a free one is used where it is in use."""
    hosts: tuple[str, ...] = ()
    """Names under which other machines open the page, such as `table.local`."""
    token: Annotated[str, Field(pattern="^([A-Za-z0-9_-]{16,64})?$")] = ""
    """What other machines need in the page's address, 16 to 64 letters and digits; empty: a new one
    at each start."""
