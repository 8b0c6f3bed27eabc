"""Runs a page in headless Chromium and returns what it reports."""

from __future__ import annotations

import json
import queue
import shutil
import subprocess
import tempfile
import threading
from collections.abc import Mapping
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from typing import Any

import pytest

needs_chromium = pytest.mark.skipif(
    shutil.which("chromium") is None, reason="chromium is not installed"
)
TYPES = {"html": "text/html", "js": "text/javascript"}
OPTIONS = (
    "--headless=new --no-sandbox --disable-gpu --disable-dev-shm-usage --no-first-run "
    "--disable-background-networking --disable-component-update --window-size=900,600"
)


def visit(files: Mapping[str, str], page: str = "index.html", timeout_s: float = 60.0) -> Any:
    """Serve `files` on the loopback, open `page`, and return what it sends with `report(value)`."""
    reports: queue.Queue[Any] = queue.Queue()

    class Handler(BaseHTTPRequestHandler):
        def do_GET(self) -> None:
            name = self.path.partition("?")[0].lstrip("/")
            self.send_response(200 if name in files else 404)
            self.send_header("Content-Type", TYPES.get(name.rpartition(".")[2], "text/plain"))
            self.end_headers()
            text = files.get(name, "")
            if name.endswith(".html"):  # A library has such words, too.
                text = text.replace("</body>", REPORT)
            self.wfile.write(text.encode())

        def do_POST(self) -> None:
            reports.put(json.loads(self.rfile.read(int(self.headers["Content-Length"]))))
            self.send_response(204)
            self.end_headers()

        def log_message(self, *_: object) -> None:
            """Print nothing."""

    with ThreadingHTTPServer(("127.0.0.1", 0), Handler) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        try:
            with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as profile:
                url = f"http://127.0.0.1:{server.server_port}/{page}"
                return _first_report(url, profile, reports, timeout_s)
        finally:
            server.shutdown()


REPORT = """<script>
const report = (value) => fetch("/report", { method: "POST", body: JSON.stringify(value) });
window.onerror = (message) => report({ error: message });
</script></body>"""


def _first_report(url: str, profile: str, reports: queue.Queue[Any], timeout_s: float) -> Any:
    command = ["chromium", *OPTIONS.split(), f"--user-data-dir={profile}", url]
    with subprocess.Popen(
        command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
    ) as chromium:
        try:
            return reports.get(timeout=timeout_s)
        finally:
            chromium.terminate()
