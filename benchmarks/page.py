"""What the control page costs the frames.

    uv run python -m benchmarks.page

Frames of the virtual camera are sensed at 30 Hz, without a page, then with one and with five that
show all pictures. It prints the median time of a frame, and the processor time of everything but
the frame's own thread. Clients run in a process of their own.
"""

from __future__ import annotations

import argparse
import json
import statistics
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import closing
from typing import Any

from halo_service.app.process import use_one_thread_each

use_one_thread_each()

from halo_calibration.guided.guide import PROMPTS  # noqa: E402
from halo_service.app.page.observer import PageObserver  # noqa: E402
from halo_service.app.page.picture_thread import PictureThread  # noqa: E402
from halo_service.app.virtual_user.cache import cached_profile  # noqa: E402
from halo_service.app.virtual_user.profile import virtual_profile  # noqa: E402
from halo_service.app.virtual_user.user import VirtualUser  # noqa: E402
from halo_service.runtime.health import Health  # noqa: E402
from halo_service.sensing import State, start, step  # noqa: E402
from halo_service.settings import Settings  # noqa: E402
from halo_service.values import Frame, TouchFrame, Tracked  # noqa: E402
from halo_service.virtual.room import Room  # noqa: E402
from halo_service.web.control_page.server import PageServer  # noqa: E402
from halo_service.web.settings import PageSettings  # noqa: E402

FPS = 30.0
PAGES = (0, 1, 5)
TURN_S = 1.0
FRAMES = 60
"""Different frames; they are sensed again and again."""
CLIENTS = """
import json, sys, threading
from websockets.sync.client import connect
url, origin, count = sys.argv[1], sys.argv[2], int(sys.argv[3])
def show(ready):
    with connect(url, origin=origin, compression=None) as page:
        page.send(json.dumps({"show": ["depth", "infrared", "colour"]}))
        for _ in page:
            pass
threads = [threading.Thread(target=show, args=(None,), daemon=True) for _ in range(count)]
for thread in threads:
    thread.start()
threads[0].join()
"""


class Nowhere:
    """A publisher that sends nothing."""

    def frame(self, touch_frame: TouchFrame) -> None:
        """Nothing."""

    def scene(self, state: State) -> None:
        """Nothing."""

    def health(self, health: Health) -> None:
        """Nothing."""


def film() -> list[Frame]:
    """Return frames of the virtual hand, with colour."""
    user = VirtualUser(Room())
    user.follow(PROMPTS["sweep"])
    user.skip(3.0)
    return [user.read(1.0) for _ in range(FRAMES)]


def measure(frames: list[Frame], hands: list[Tracked], seconds: float) -> Iterator[dict[str, Any]]:
    """Yield the figures for each number of pages; they take turns, so that a busy machine is
    equally busy for all."""
    settings = Settings()
    profile = cached_profile(Room(), settings, virtual_profile)
    spent_ms: dict[int, list[float]] = {pages: [] for pages in PAGES}
    others_s, wall_s = dict.fromkeys(PAGES, 0.0), dict.fromkeys(PAGES, 0.0)
    with closing(PageServer(PageSettings(port=18765))) as server:
        observer = PageObserver(Nowhere(), server, profile.camera, lambda: "good", dict)
        pictures = PictureThread(server, lambda: observer.newest)
        clients = _clients(server, max(PAGES))
        while len(server.wanted()) < 3 or len(server.clients) < max(PAGES):
            time.sleep(0.05)
        every = sorted(server.clients, key=id)
        state = start(profile, settings.sensing)
        for turn in range(round(seconds / TURN_S) * len(PAGES)):
            pages = PAGES[turn % len(PAGES)]
            server.clients = set(every[:pages])
            began_s, cpu_s, own_s = time.monotonic(), time.process_time(), time.thread_time()
            for n in range(round(TURN_S * FPS)):
                k = (turn * 30 + n) % len(frames)
                time.sleep(max(began_s + n / FPS - time.monotonic(), 0.0))
                before_s = time.perf_counter()
                touch_frame, state = step(state, frames[k], hands[k])
                observer.frame(touch_frame)
                spent_ms[pages].append(1000.0 * (time.perf_counter() - before_s))
                observer.watch(frames[k])
                state = observer.turn(state)
            wall_s[pages] += time.monotonic() - began_s
            own_s = time.thread_time() - own_s
            others_s[pages] += time.process_time() - cpu_s - own_s
        clients.kill()
        clients.wait()
        server.clients = set(every)
        pictures.close()
        observer.close()
    for pages in PAGES:
        yield {
            "pages": pages,
            "frame_median_ms": round(statistics.median(spent_ms[pages]), 3),
            "core": round(others_s[pages] / wall_s[pages], 3),
        }


def _clients(server: PageServer, pages: int) -> subprocess.Popen[bytes]:
    here = f"127.0.0.1:{server.port}"
    command = [sys.executable, "-c", CLIENTS, f"ws://{here}/live", f"http://{here}", str(pages)]
    return subprocess.Popen(command)


def main() -> None:
    """Print a line for each number of pages."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seconds", type=float, default=20.0, help="for each number of pages")
    options = parser.parse_args()
    frames = film()
    for figures in measure(frames, _hands(frames), options.seconds):
        print(json.dumps(figures), flush=True)


def _hands(frames: list[Frame]) -> list[Tracked]:
    from halo_service.app.hand_detector import HandDetector

    profile = cached_profile(Room(), Settings(), virtual_profile)
    detector = HandDetector(profile.camera, profile, Settings().tracking)
    with closing(detector):
        return [detector.detect(frame) for frame in frames]


if __name__ == "__main__":
    main()
