"""This commit's cost beside an older one's, in one run.

    uv run python benchmarks/beside.py [COMMIT] [--rounds N] [--only TEXT]

Checks the older commit out into a temporary folder and runs each case in both, in turns, so that
other load on the machine affects both. Prints the CPU time of the process, or wall time where it
says so, and the ratio. Both use this environment's packages. A run that is not counted comes first:
it compiles the modules, as the first start of a new installation does.
"""

from __future__ import annotations

import argparse
import os
import statistics
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
FOLDERS = ("calibration", "protocol", "clients/*")
"""What a checkout puts on Python's path besides itself."""
SENSOR = """
import inspect, time, cv2
from halo_service.virtual.scenarios import start_scenario
from halo_service.virtual.sensor import Sensor
from halo_service.virtual.sim_url import parse_sim_url
cv2.setNumThreads(1)
request = parse_sim_url("sim:{scenario}?drop=0")
running = start_scenario(request.scenario, request.room)
options = {{"live": True}} if {live} and "live" in inspect.signature(Sensor).parameters else {{}}
sensor = Sensor(request.room, colour_times={times}, **options)
if {live} and hasattr(sensor, "with_colour"):
    sensor.with_colour(False)  # as the service does once its background is measured
def draw(k):
    moment = running.at(5.0 + k / 30.0)
    sensor.frame(5_000_000 + 33_333 * k, moment.hands, moment.things)
for k in range(30):  # what is built at first use
    draw(k)
began_s = time.process_time()
for k in range(30, 120):
    draw(k)
print(1000.0 * (time.process_time() - began_s) / 90)
"""
IMPORTS = """
import time
import halo_service.app.service.serve
import halo_service.hand_tracking.hands
print(1000.0 * time.process_time())
"""
START = """
import os, shutil, socket, subprocess, sys, tempfile, time
from pathlib import Path
import halo_protocol as wire
from halo_service.hand_tracking.model import hand_model
def start(cache):
    with socket.socket(type=socket.SOCK_DGRAM) as client:
        client.bind(("127.0.0.1", 0))
        client.settimeout(240.0)
        destination = f"127.0.0.1:{{client.getsockname()[1]}}"
        options = ["--source", "sim", "--osc", destination, "--no-zenoh", "--control-port", "9323"]
        code = "from halo_service.app.cli import main; main()"
        began_s = time.monotonic()
        service = subprocess.Popen(
            [sys.executable, "-c", code, "serve", *options],
            env=os.environ | {{"XDG_CACHE_HOME": cache, "XDG_DATA_HOME": cache}},
            stderr=subprocess.DEVNULL,
        )
        try:
            found = False
            while not found:
                messages = wire.decode(client.recv(65536))
                found = any(isinstance(message, wire.Pointer) for _, message in messages)
            print(1000.0 * (time.monotonic() - began_s))
        finally:
            service.terminate()
            service.wait()
with tempfile.TemporaryDirectory() as cache:
    folder = Path(cache) / "halo-service"  # with the model, but without a measured room
    folder.mkdir()
    shutil.copy(hand_model(None), folder)
    for _ in range({starts}):
        start(cache)
"""
SIMULATE = """
import tempfile, time
from pathlib import Path
from halo_service.app.cli import main
with tempfile.TemporaryDirectory() as folder:
    began_s = time.monotonic()
    main(["simulate", "drumming", "--out", str(Path(folder) / "out.mkv"), "--seconds", "4"])
    print(1000.0 * (time.monotonic() - began_s) / 120)
"""
CASES = (
    ("virtual camera, live, one hand, ms a frame", SENSOR.format(scenario="demo", times=2, live=1)),
    ("virtual camera, live, two hands", SENSOR.format(scenario="drumming", times=2, live=1)),
    ("virtual camera, full, two hands", SENSOR.format(scenario="drumming", times=1, live=0)),
    ("imports of 'halo serve', ms", IMPORTS),
    ("'halo simulate', two hands, ms of wall time a frame", SIMULATE),
    ("'halo serve' to the first pointer, ms of wall time", START.format(starts=1)),
    ("the same, the virtual room measured before", START.format(starts=2)),
)


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("commit", nargs="?", default="HEAD~1")
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--only", default="", help="cases with this text in their names")
    given = parser.parse_args()
    with tempfile.TemporaryDirectory() as scratch:
        older = Path(scratch) / "older"
        git("worktree", "add", "--detach", str(older), given.commit)
        try:
            os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
            os.environ["PYTHONPYCACHEPREFIX"] = str(Path(scratch) / "compiled")
            for name, code in (case for case in CASES if given.only in case[0]):
                _, *pairs = [(cost(older, code), cost(ROOT, code)) for _ in range(given.rounds + 1)]
                before, now = (statistics.median(each) for each in zip(*pairs, strict=True))
                print(f"{name:52} {before:8.1f} {now:8.1f}   ratio {now / before:4.2f}", flush=True)
        finally:
            git("worktree", "remove", "--force", str(older))


def cost(checkout: Path, code: str) -> float:
    """Run code on a checkout; return the number that it prints last."""
    folders = [folder for pattern in FOLDERS for folder in checkout.glob(pattern)]
    path = os.pathsep.join(map(str, [checkout, *folders]))
    environment = os.environ | {"PYTHONPATH": path, "OMP_NUM_THREADS": "1"}
    command = [sys.executable, "-c", code]
    done = subprocess.run(command, env=environment, cwd="/", check=True, stdout=subprocess.PIPE)
    return float(done.stdout.split()[-1])


def git(*arguments: str) -> None:
    """Run git in this checkout."""
    subprocess.run(["git", "-C", str(ROOT), *arguments], check=True, capture_output=True)


if __name__ == "__main__":
    main()
