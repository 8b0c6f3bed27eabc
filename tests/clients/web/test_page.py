"""The example page draws the fingers of a service, in Chromium."""

from __future__ import annotations

import itertools
import threading
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path

import pytest

from halo_service.web.server import WebServer
from halo_service.web.settings import WebSettings
from tests.browser import needs_chromium, visit
from tests.outputs.samples import fingers, frame

WEB = Path(__file__).parents[3] / "clients" / "web"
# Once the page shows fingers: its status, and how many pixels have the colour of a touch.
LOOK = """<script>
const timer = setInterval(() => {
  const text = document.querySelector("#status").textContent;
  if (!text.includes(" fingers") || text.includes(" 0 fingers")) return;
  clearInterval(timer);
  const canvas = document.querySelector("canvas");
  const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
  let orange = 0;
  for (let i = 0; i < data.length; i += 4) orange += data[i] > 200 && data[i + 2] < 120;
  report({ text, orange });
}, 100);
</script></body>"""


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


@needs_chromium
def test_the_page_draws_fingers(url: str) -> None:
    files = {each.name: each.read_text() for each in WEB.glob("*.*")}
    files["index.html"] = files["index.html"].replace("</body>", LOOK)
    found = visit(files, f"index.html?{url}")
    assert found["text"].startswith(f"{url}: 4 fingers"), found
    assert found["orange"] > 100
