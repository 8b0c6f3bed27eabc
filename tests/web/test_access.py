"""Requests of foreign pages, and of names that point here, are refused."""

from __future__ import annotations

import pytest

from halo_service.web.access import Access

OPEN = Access(frozenset({"table.local", "192.168.1.5"}), frozenset({"https://example.org", "null"}))


@pytest.mark.parametrize(
    ("access", "host", "origin"),
    [
        (Access(), "127.0.0.1:4258", None),
        (Access(), "localhost:4258", "http://localhost:3000"),
        (Access(), "[::1]:4258", "http://127.0.0.1"),
        (OPEN, "table.local", "http://192.168.1.5:80"),
        (OPEN, "192.168.1.5:4258", "https://example.org"),
        (OPEN, "localhost", "null"),
    ],
)
def test_allowed(access: Access, host: str, origin: str | None) -> None:
    assert access.refusal(host, origin) is None


@pytest.mark.parametrize(
    ("access", "host", "origin", "says"),
    [
        (Access(), "evil.example:4258", None, "add the name to [web] hosts"),
        (Access(), "", None, "this server is not ''"),
        (Access(), "192.168.1.5", None, "[web] hosts"),
        (Access(), "127.0.0.1.evil.example", None, "[web] hosts"),
        (Access(), "localhost@evil.example", None, "[web] hosts"),
        (Access(), "[::1", None, "[web] hosts"),
        (Access(), "localhost", "https://evil.example", "add it to [web] origins"),
        (Access(), "localhost", "null", "[web] origins"),
        (Access(), "localhost", "", "[web] origins"),
        (Access(), "localhost", "http://localhost.evil.example", "[web] origins"),
        (OPEN, "localhost", "http://example.org", "[web] origins"),
    ],
)
def test_refused(access: Access, host: str, origin: str | None, says: str) -> None:
    why = access.refusal(host, origin)
    assert why is not None and says in why
