"""A service for the web pages to receive from."""

from __future__ import annotations

import itertools
import threading
from collections.abc import Iterator
from contextlib import closing

import pytest

from halo_service.web.server import WebServer
from halo_service.web.settings import WebSettings
from tests.outputs.samples import fingers, frame


@pytest.fixture
def url(free_tcp_port: int) -> Iterator[str]:
    """A service with four fingers, two of which touch."""
    over = threading.Event()

    def run(server: WebServer) -> None:
        for number in itertools.count():
            server.send(frame(number, fingers(4)))
            if over.wait(0.03):
                return

    with closing(WebServer(WebSettings(port=free_tcp_port))) as server:
        thread = threading.Thread(target=run, args=(server,))
        thread.start()
        yield server.url
        over.set()
        thread.join()
