"""The control page answers its own pages alone, and on a network those with a token."""

from __future__ import annotations

import pytest

from halo_service.web.control_page.access import PageAccess, Refused, Role

LOCAL = PageAccess()
OPEN = PageAccess(
    frozenset({"192.168.1.5", "table.local"}), {"o" * 16: "operator", "v" * 16: "viewer"}
)


@pytest.mark.parametrize(
    ("access", "host", "token", "role"),
    [
        (LOCAL, "127.0.0.1:8765", None, "operator"),
        (LOCAL, "localhost:8765", "anything", "operator"),
        (LOCAL, "[::1]:8765", None, "operator"),
        (OPEN, "192.168.1.5:8765", "o" * 16, "operator"),
        (OPEN, "table.local", "v" * 16, "viewer"),
        (OPEN, "127.0.0.1:8765", "v" * 16, "viewer"),
    ],
)
def test_allowed(access: PageAccess, host: str, token: str | None, role: Role) -> None:
    assert access.role(host, token) == role


@pytest.mark.parametrize(
    ("access", "host", "token", "status"),
    [
        (LOCAL, "evil.example:8765", None, 403),
        (LOCAL, "127.0.0.1.evil.example", None, 403),
        (LOCAL, "192.168.1.5:8765", None, 403),
        (LOCAL, "", None, 403),
        (LOCAL, "[::1", None, 403),
        (OPEN, "192.168.1.5:8765", None, 401),
        (OPEN, "192.168.1.5:8765", "o" * 15, 401),
        (OPEN, "192.168.1.5:8765", "ö" * 16, 401),
        (OPEN, "127.0.0.1:8765", None, 401),
        (OPEN, "evil.example", "o" * 16, 403),
    ],
)
def test_refused(access: PageAccess, host: str, token: str | None, status: int) -> None:
    with pytest.raises(Refused) as refused:
        access.role(host, token)
    assert refused.value.status == status


@pytest.mark.parametrize(
    ("host", "origin", "allowed"),
    [
        ("127.0.0.1:8765", "http://127.0.0.1:8765", True),
        ("Table.local:8765", "http://table.local:8765", True),
        ("127.0.0.1:8765", None, False),
        ("127.0.0.1:8765", "null", False),
        ("127.0.0.1:8765", "http://127.0.0.1:3000", False),
        ("127.0.0.1:8765", "https://127.0.0.1:8765", False),
        ("127.0.0.1:8765", "http://127.0.0.1:8765.evil.example", False),
        ("", "http://", False),
    ],
)
def test_changes_come_from_the_page_itself(host: str, origin: str | None, allowed: bool) -> None:
    if allowed:
        LOCAL.check_origin(host, origin)
        return
    with pytest.raises(Refused):
        LOCAL.check_origin(host, origin)
