"""Take pictures of every view of the control page, on the virtual camera.

    uv run python docs/page_pictures.py FOLDER

It needs Debian's `chromium`. A running service can be shown with `--url http://127.0.0.1:8765/`.
"""

from __future__ import annotations

import argparse
import re
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from playwright.sync_api import Page, sync_playwright

VIEWS = ("guide", "live", "setup", "settings", "profiles", "outputs", "nodes", "record", "log")
LOOKS = {
    "light": {"viewport": {"width": 1280, "height": 860}, "color_scheme": "light"},
    "dark": {"viewport": {"width": 1280, "height": 860}, "color_scheme": "dark"},
    "phone": {"viewport": {"width": 390, "height": 844}, "color_scheme": "light"},
}
SETTLE_MS = 2500
"""Until a view has fetched its values, and the virtual hand has moved a little."""


@contextmanager
def service(*options: str) -> Iterator[str]:
    """Start a service on the virtual camera; yield the page's address."""
    halo = Path(sys.executable).with_name("halo")
    with tempfile.TemporaryDirectory() as folder:
        config = Path(folder) / "halo.toml"
        config.write_text("# for pictures of the control page\n")
        command = [halo, "serve", "--source", "sim:demo", "--no-zenoh", "--no-web", "--no-osc"]
        process = subprocess.Popen(
            [*map(str, command), "--config", str(config), *options],
            stderr=subprocess.PIPE,
            text=True,
        )
        try:
            yield _address(process)
        finally:
            process.terminate()
            process.communicate()


def _address(process: subprocess.Popen[str]) -> str:
    assert process.stderr is not None
    for line in process.stderr:
        found = re.search(r"page: (http://\S+)", line)
        if found:
            return found[1]
    raise SystemExit("the service ended before its page was there")


def take(url: str, folder: Path, looks: list[str], views: list[str]) -> None:
    """Write a PNG for each view and look."""
    folder.mkdir(parents=True, exist_ok=True)
    with sync_playwright() as playwright:
        chromium = playwright.chromium.launch(
            executable_path=shutil.which("chromium"), args=["--no-sandbox"]
        )
        for look in looks:
            page = chromium.new_context(**LOOKS[look]).new_page()  # type: ignore[arg-type]
            page.on("console", lambda each: print("console:", each.text, file=sys.stderr))
            for view in views:
                _one(page, url, view)
                page.screenshot(path=folder / f"{view}-{look}.png", full_page=True)
        chromium.close()


def _one(page: Page, url: str, view: str) -> None:
    page.goto(f"{url}#{view}")
    page.reload()
    if view == "live":
        for kind in ("depth", "infrared", "colour"):
            page.check(f"#show-{kind}")
    page.wait_for_timeout(SETTLE_MS)
    page.evaluate("scrollTo(0, 0)")


def main() -> None:
    """Take the pictures."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--url", help="of a running service's page")
    parser.add_argument("--looks", nargs="+", choices=tuple(LOOKS), default=[*LOOKS])
    parser.add_argument("--views", nargs="+", choices=VIEWS, default=[*VIEWS])
    options = parser.parse_args()
    if options.url:
        take(options.url, options.folder, options.looks, options.views)
        return
    with service() as url:
        take(url, options.folder, options.looks, options.views)


if __name__ == "__main__":
    main()
