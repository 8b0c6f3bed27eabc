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
from contextlib import closing

from halo_service.app.process import use_one_thread_each

use_one_thread_each()

from halo_service.app.page.observer import PageObserver  # noqa: E402
from halo_service.app.page.picture_thread import PictureThread  # noqa: E402
from halo_service.app.virtual_user.cache import cached_profile  # noqa: E402
from halo_service.app.virtual_user.profile import virtual_profile  # noqa: E402
from halo_service.runtime.health import Health  # noqa: E402
from halo_service.sensing import State, start, step  # noqa: E402
from halo_service.settings import Settings  # noqa: E402
from halo_service.values import Frame, TouchFrame, Tracked  # noqa: E402
from halo_service.virtual.live import VirtualKinect  # noqa: E402
from halo_service.virtual.room import Room  # noqa: E402
from halo_service.virtual.sim_url import parse_sim_url  # noqa: E402
from halo_service.web.control_page.server import PageServer  # noqa: E402
from halo_service.web.settings import PageSettings  # noqa: E402

FPS = 30.0
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
    frames: list[Frame] = []
    with closing(VirtualKinect(parse_sim_url("sim:demo"))) as camera:
        while len(frames) < FRAMES:
            frame = camera.read(1.0)
            if isinstance(frame, Frame):
                frames.append(frame)
    return frames


def measure(
    frames: list[Frame], hands: list[Tracked], pages: int, seconds: float
) -> dict[str, float]:
    """Return the figures for a number of pages."""
    settings = Settings()
    profile = cached_profile(Room(), settings, virtual_profile)
    with closing(PageServer(PageSettings(port=18765))) as server:
        observer = PageObserver(Nowhere(), server, profile.camera, lambda: "good", dict)
        pictures = PictureThread(server, lambda: observer.newest)
        clients = _clients(server, pages)
        while len(server.clients) < pages:
            time.sleep(0.05)
        state, spent_ms = start(profile, settings.sensing), []
        began_s, cpu_s, own_s = time.monotonic(), time.process_time(), time.thread_time()
        for n in range(round(seconds * FPS)):
            frame, tracked = frames[n % len(frames)], hands[n % len(frames)]
            due_s = began_s + n / FPS
            time.sleep(max(due_s - time.monotonic(), 0.0))
            before_s = time.perf_counter()
            touch_frame, state = step(state, frame, tracked)
            observer.frame(touch_frame)
            spent_ms.append(1000.0 * (time.perf_counter() - before_s))
            observer.watch(frame)
            state = observer.turn(state)
        wall_s = time.monotonic() - began_s
        others_s = (time.process_time() - cpu_s) - (time.thread_time() - own_s)
        if clients is not None:
            clients.kill()
            clients.wait()
        pictures.close()
        observer.close()
    return {
        "pages": pages,
        "frame_median_ms": round(statistics.median(spent_ms), 3),
        "core": round(others_s / wall_s, 3),
    }


def _clients(server: PageServer, pages: int) -> subprocess.Popen[bytes] | None:
    if pages == 0:
        return None
    here = f"127.0.0.1:{server.port}"
    command = [sys.executable, "-c", CLIENTS, f"ws://{here}/live", f"http://{here}", str(pages)]
    return subprocess.Popen(command)


def main() -> None:
    """Print a line for each number of pages, again and again."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seconds", type=float, default=8.0, help="for each number of pages")
    parser.add_argument("--rounds", type=int, default=3)
    options = parser.parse_args()
    frames = film()
    hands = _hands(frames)
    for _ in range(options.rounds):
        for pages in (0, 1, 5):
            print(json.dumps(measure(frames, hands, pages, options.seconds)), flush=True)


def _hands(frames: list[Frame]) -> list[Tracked]:
    from halo_service.app.hand_detector import HandDetector

    profile = cached_profile(Room(), Settings(), virtual_profile)
    detector = HandDetector(profile.camera, profile, Settings().tracking)
    with closing(detector):
        return [detector.detect(frame) for frame in frames]


if __name__ == "__main__":
    main()
