"""The server of the control page, asked as browsers and as attackers ask."""

from __future__ import annotations

import http.client
import json
import re
import threading
from collections.abc import Callable, Iterator
from contextlib import ExitStack, closing
from typing import Any

import pytest
from websockets.exceptions import ConnectionClosed, InvalidStatus
from websockets.sync.client import ClientConnection, connect

from halo_service.errors import UserError
from halo_service.web.control_page.calls import LARGEST_JSON, Call
from halo_service.web.control_page.files import FOLDER, static_files
from halo_service.web.control_page.server import COOKIE, MAX_PAGES, PageServer
from halo_service.web.settings import PageSettings

MOST_BYTES = 300_000
"""The whole page with its scripts."""
TOKEN = "abcdefghijklmnop"


def refuse(_: object) -> None:
    raise UserError("the hand is in the way")


CALLS = {
    "echo": Call(lambda value: value),
    "look": Call(lambda value: "seen", reads=True),
    "file": Call(lambda content: content[::-1], takes_file=True),
    "refuse": Call(refuse),
    "needs": Call(lambda value: value["name"]),
}


@pytest.fixture
def server(free_port: Callable[[], int]) -> Iterator[PageServer]:
    with closing(PageServer(PageSettings(port=free_port()))) as server:
        server.calls = CALLS
        yield server


@pytest.fixture
def networked(free_port: Callable[[], int]) -> Iterator[PageServer]:
    """As on a network: a token is needed."""
    settings = PageSettings(host="0.0.0.0", port=free_port(), token=TOKEN)
    with closing(PageServer(settings, frozenset({"192.0.2.7"}))) as server:
        server.calls = CALLS
        yield server


class Answer:
    """Status, headers and body."""

    def __init__(self, response: http.client.HTTPResponse) -> None:
        self.status = response.status
        self.headers = response.headers
        self.body = response.read()

    @property
    def error(self) -> str:
        return str(json.loads(self.body)["error"])


def ask(
    server: PageServer, method: str, path: str, body: bytes | None = None, **headers: str
) -> Answer:
    with closing(http.client.HTTPConnection("127.0.0.1", server.port, timeout=10.0)) as connection:
        named = {name.replace("_", "-"): value for name, value in headers.items()}
        connection.request(method, path, body, named)
        return Answer(connection.getresponse())


def ours(server: PageServer) -> dict[str, str]:
    """The headers that our own page sends."""
    return {"Origin": f"http://127.0.0.1:{server.port}", "X_Halo_Page": "1"}


def call(server: PageServer, name: str, value: Any = None, **headers: str) -> Answer:
    body = value if isinstance(value, bytes) else json.dumps(value or {}).encode()
    return ask(server, "POST", f"/call/{name}", body, **{**ours(server), **headers})


def test_the_whole_page_is_small_and_asks_nothing_of_others() -> None:
    files = static_files()
    assert sum(len(file.content) for file in files.values()) < MOST_BYTES
    for path, file in files.items():
        text = file.content.decode()
        found = set(re.findall(r"https?://[^\s\"'`)]+", text)) - {"http://www.w3.org/2000/svg"}
        assert not found, f"{path} names {found}"
        assert "innerHTML" not in text and " style=" not in text, path


def test_each_file_is_served_with_its_type_and_a_policy(server: PageServer) -> None:
    for path, file in static_files().items():
        answer = ask(server, "GET", path)
        assert (answer.status, answer.body) == (200, file.content)
        assert answer.headers["Content-Type"] == file.type
        assert "default-src 'none'" in answer.headers["Content-Security-Policy"]
        assert answer.headers["X-Frame-Options"] == "DENY"
        again = ask(server, "GET", path, If_None_Match=answer.headers["ETag"])
        assert again.status == 304


@pytest.mark.parametrize(
    "path",
    [
        "/../pyproject.toml",
        "/..%2f..%2fsettings.py",
        "/%2e%2e/server.py",
        "//etc/passwd",
        "/static/index.html",
        f"{FOLDER}/index.html",
        "/index.html/",
        "/%00",
        "/" + "a" * 5000,
    ],
)
def test_no_other_file_is_ever_opened(server: PageServer, path: str) -> None:
    assert ask(server, "GET", path).status == 404


def test_a_call_returns_its_value_or_a_sentence(server: PageServer) -> None:
    assert json.loads(call(server, "echo", {"a": [1, "ö"]}).body) == {"a": [1, "ö"]}
    assert call(server, "file", b"\0\1\2").body == b"\2\1\0"
    refused = call(server, "refuse")
    assert (refused.status, refused.error) == (422, "the hand is in the way")


@pytest.mark.parametrize(
    ("headers", "status"),
    [
        ({"Origin": "https://evil.example"}, 403),
        ({"Origin": "null"}, 403),
        ({"Origin": ""}, 403),
        ({"X_Halo_Page": "0"}, 403),
        ({"Host": "evil.example"}, 403),
        ({"Host": "evil.example", "Origin": "http://evil.example"}, 403),
    ],
)
def test_foreign_requests_are_refused(
    server: PageServer, headers: dict[str, str], status: int
) -> None:
    assert call(server, "echo", **headers).status == status


@pytest.mark.parametrize(
    ("name", "body", "status"),
    [
        ("nothing", b"{}", 404),
        ("../echo", b"{}", 405),
        ("echo", b"", 400),
        ("echo", b"\xff\xfe", 400),
        ("echo", b"[1]", 400),
        ("echo", b"[" * 60_000, 400),
        ("needs", b"{}", 400),
        ("echo", b'"' + b"a" * LARGEST_JSON + b'"', 413),
    ],
)
def test_malformed_requests_are_refused(
    server: PageServer, name: str, body: bytes, status: int
) -> None:
    assert call(server, name, body).status == status
    assert call(server, "echo", {"still": "there"}).status == 200


def test_a_form_of_another_page_cannot_call(server: PageServer) -> None:
    kind = "application/x-www-form-urlencoded"
    assert ask(server, "POST", "/call/echo", b"{}", Content_Type=kind).status == 403
    assert ask(server, "OPTIONS", "/call/echo", Origin="https://evil.example").status == 405
    assert ask(server, "GET", "/call/echo").status == 404


def test_more_calls_at_once_than_wait_are_refused(server: PageServer) -> None:
    go_on = threading.Event()
    server.calls = {"slow": Call(lambda _: go_on.wait(10.0))}
    found: list[int] = []
    threads = [
        threading.Thread(target=lambda: found.append(call(server, "slow").status))
        for _ in range(12)
    ]
    for thread in threads:
        thread.start()
    while found.count(503) < 4:
        assert len(found) < 12
    go_on.set()
    for thread in threads:
        thread.join()
    assert sorted(found) == [200] * 8 + [503] * 4


def test_on_a_network_a_token_is_needed_and_the_viewer_may_only_look(
    networked: PageServer,
) -> None:
    viewer = next(token for token, role in networked.tokens.items() if role == "viewer")
    assert ask(networked, "GET", "/").status == 401
    assert call(networked, "echo").status == 401
    for token, changes in ((TOKEN, 200), (viewer, 403)):
        page = ask(networked, "GET", f"/?token={token}")
        cookie = page.headers["Set-Cookie"]
        assert page.status == 200 and "HttpOnly" in cookie and "SameSite=Strict" in cookie
        stored = cookie.partition(";")[0]
        assert stored.startswith(COOKIE)
        assert ask(networked, "GET", "/app.js", Cookie=stored).status == 200
        assert call(networked, "look", Cookie=stored).status == 200
        assert call(networked, "echo", Cookie=stored).status == changes
    host = f"192.0.2.7:{networked.port}"
    assert ask(networked, "GET", f"/?token={TOKEN}", Host=host).status == 200
    assert ask(networked, "GET", f"/?token={TOKEN}", Host="192.0.2.8").status == 403


def live(server: PageServer, origin: str | None = None) -> ClientConnection:
    url = f"ws://127.0.0.1:{server.port}/live"
    return connect(url, origin=origin or f"http://127.0.0.1:{server.port}")  # type: ignore[arg-type]


def test_a_page_gets_values_and_only_the_pictures_that_it_shows(server: PageServer) -> None:
    joined = threading.Event()
    server.on_join = lambda client: joined.set()
    with live(server) as page:
        assert joined.wait(10.0)
        assert server.wanted() == set()
        page.send(json.dumps({"show": ["depth", "../etc", 7]}))
        while server.wanted() != {"depth"}:
            pass
        server.post(lambda: server.send_picture("colour", b"hidden"))
        server.post(lambda: server.send_picture("depth", b"shown"))
        server.post(lambda: server.broadcast({"kind": "log"}))
        assert {page.recv(10.0), page.recv(10.0)} == {b"shown", '{"kind":"log"}'}


def test_live_connections_are_checked_and_limited(server: PageServer) -> None:
    with pytest.raises(InvalidStatus) as refused, live(server, "https://evil.example"):
        pass
    assert refused.value.response.status_code == 403
    with ExitStack() as stack:
        pages = [stack.enter_context(live(server)) for _ in range(MAX_PAGES)]
        with pytest.raises(InvalidStatus) as refused, live(server):
            pass
        assert refused.value.response.status_code == 503
        pages[0].send("x" * 5000)
        with pytest.raises(ConnectionClosed):
            pages[0].recv(10.0)
        for text in ("", "{", "[]", '{"show": {}}', "[" * 2000):
            pages[1].send(text)
        server.post(lambda: server.broadcast({"kind": "log"}))
        assert pages[1].recv(10.0) == '{"kind":"log"}'


def test_a_port_in_use_gets_another_one(
    server: PageServer, caplog: pytest.LogCaptureFixture
) -> None:
    with closing(PageServer(PageSettings(port=server.port))) as second:
        assert second.port != server.port
        assert ask(second, "GET", "/").status == 200
    assert f"page: port {server.port} is in use, so this service uses {second.port}" in caplog.text
