"""The example page draws the fingers of a service, in Chromium."""

from __future__ import annotations

import json
import shutil
import subprocess
import threading
from collections.abc import Callable
from contextlib import closing
from dataclasses import replace
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


@needs_chromium
def test_the_page_draws_fingers(url: str) -> None:
    files = {each.name: each.read_text() for each in WEB.glob("*.*")}
    files["index.html"] = files["index.html"].replace("</body>", LOOK)
    found = visit(files, f"index.html?{url}")
    assert found["text"].startswith(f"{url}: 4 fingers"), found
    assert found["orange"] > 100


FOLLOW = """
const found = [];
const say = (text) => { if (found.at(-1) !== text) found.push(text); };
connect(url, {
  frame: ({ session }) => { say(session); if (session === "s2") report(found); },
  down: ({ key }) => say(`down ${key}`),
  up: ({ key }) => say(`up ${key}`),
  lost: ({ session }) => say(`lost ${session}`),
});
"""
"""Lists what a client gets until the second session."""


def in_chromium(url: str) -> list[str]:
    head = 'import { connect } from "./halo.js";\nconst url = location.search.slice(1);'
    page = f'<!doctype html><body><script type="module">{head}{FOLLOW}</script></body>'
    files = {each.name: each.read_text() for each in WEB.glob("*.js")}
    return list(visit({**files, "index.html": page}, f"index.html?{url}"))


def in_node(url: str) -> list[str]:
    head = f'import {{ connect }} from "{WEB / "halo.js"}";\nconst url = "{url}";\n'
    head += "const report = (f) => { console.log(JSON.stringify(f)); process.exit(); };\n"
    done = subprocess.run(
        [*NODE, "--input-type=module", "-e", head + FOLLOW],
        capture_output=True, text=True, timeout=60,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    return list(json.loads(done.stdout))


NODE = ("node", "--experimental-websocket")
"""Node 22 needs no option, and older ones than 20.10 have no WebSocket."""


def node_has_websocket() -> bool:
    if shutil.which("node") is None:
        return False
    done = subprocess.run([*NODE, "-p", "typeof WebSocket"], capture_output=True, text=True)
    return done.stdout.strip() == "function"


needs_node = pytest.mark.skipif(not node_has_websocket(), reason="node has no WebSocket")


@pytest.mark.parametrize(
    "follow",
    [pytest.param(in_chromium, marks=needs_chromium), pytest.param(in_node, marks=needs_node)],
)
def test_the_client_waits_for_a_service_and_finds_it_again(
    follow: Callable[[str], list[str]], free_tcp_port: int
) -> None:
    over = threading.Event()

    def run() -> None:
        for session in ("s1", "s2"):
            if over.wait(0.4):
                return
            with closing(WebServer(WebSettings(port=free_tcp_port))) as server:
                for number in range(20 if session == "s1" else 600):
                    sent = frame(number, fingers(2))
                    server.send(replace(sent, header=replace(sent.header, session=session)))
                    if over.wait(0.05):
                        return

    thread = threading.Thread(target=run)
    thread.start()
    try:
        found = follow(f"ws://127.0.0.1:{free_tcp_port}/halo")
    finally:
        over.set()
        thread.join()
    assert found[0] == "s1"
    assert "up desk/table/s1/101/3" in found, "its touch ends"
    assert found[-1] == "s2"
