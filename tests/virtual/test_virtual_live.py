"""The live virtual camera: quick, bounded, and never an orphan. About 12 s."""

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from halo_service.errors import UserError
from halo_service.sources import ColourSwitch
from halo_service.virtual.live import VirtualKinect
from halo_service.virtual.sim_url import parse_sim_url

PATIENCE_S = 30.0
"""With a busy machine, for what must happen at all."""


def alive(pid: int) -> bool:
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return False
    state = Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()[0]
    return state != "Z"


def gone(pid: int, seconds: float = PATIENCE_S) -> bool:
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        if not alive(pid):
            return True
        time.sleep(0.02)
    return False


def first(kinect: VirtualKinect):
    end = time.monotonic() + PATIENCE_S
    while time.monotonic() < end:
        frame = kinect.read(0.5)
        if frame is not None:
            return frame
    raise AssertionError(f"no frame within {PATIENCE_S} s")


def test_frames_come_in_time_and_in_order_with_their_truth(tmp_path):
    path = tmp_path / "truth.jsonl"
    with VirtualKinect(parse_sim_url("sim:demo?drop=0"), truth_path=str(path)) as kinect:
        assert kinect.kind == "virtual"
        frame = first(kinect)
        assert frame.depth.shape == (576, 640)
        assert frame.colour.shape == (720, 1280, 3)
        times = [frame.time_us]
        end = time.monotonic() + 3.0
        while time.monotonic() < end:
            frame = kinect.read(1.0)
            assert abs(frame.time_us / 1e6 - time.time()) < 1.0
            times.append(frame.time_us)
    assert all(np.diff(times) > 0)
    # How many of the 30 a second arrive is the machine's business; each keeps to the 30 Hz grid.
    periods = np.diff(times) / (1e6 / 30)
    assert np.abs(periods - np.round(periods)).max() < 0.09
    assert periods.min() > 0.9
    lines = [json.loads(line) for line in path.read_text().splitlines()]
    listed = [line["time_us"] for line in lines if "fingers" in line]
    assert set(times) <= set(listed)
    assert any("contact" in line for line in lines)


def test_colour_is_left_out_while_no_part_needs_it():
    with VirtualKinect(parse_sim_url("sim:demo?drop=0")) as kinect:
        assert isinstance(kinect, ColourSwitch)
        assert first(kinect).colour is not None
        for wanted in (False, True):
            kinect.with_colour(wanted)
            frames = [first(kinect) for _ in range(6)]  # those on the way still have the old one
            assert (frames[-1].colour is not None) is wanted
            assert frames[-1].depth.any()


def test_a_slow_reader_gets_the_newest_frame_and_memory_stays_bounded():
    with VirtualKinect(parse_sim_url("sim:idle?drop=0"), colour=False) as kinect:
        frame = first(kinect)
        assert frame.colour is None
        time.sleep(1.0)
        late = kinect.read(0.5)
        assert late.time_us - frame.time_us > 700_000
        assert time.time() - late.time_us / 1e6 < 0.5


def test_a_frame_stays_as_it_was_when_later_ones_are_written():
    with VirtualKinect(parse_sim_url("sim:demo"), colour=False) as kinect:
        frame = first(kinect)
        copy = frame.depth.copy()
        time.sleep(0.4)
        kinect.read(0.5)
        assert np.array_equal(frame.depth, copy)


def test_closing_ends_the_worker_and_may_be_done_twice():
    kinect = VirtualKinect(parse_sim_url("sim:idle"), colour=False)
    first(kinect)
    pid = kinect._process.pid
    kinect.close()
    kinect.close()
    assert gone(pid)


def test_a_worker_that_dies_is_one_sentence():
    with VirtualKinect(parse_sim_url("sim:idle"), colour=False) as kinect:
        first(kinect)
        os.kill(kinect._process.pid, signal.SIGKILL)
        with pytest.raises(UserError, match="ended unexpectedly"):
            for _ in range(20):
                kinect.read(0.2)


def test_a_room_that_cannot_be_drawn_is_one_sentence(tmp_path):
    (tmp_path / "noise.png").write_bytes(b"no picture")
    with (
        VirtualKinect(parse_sim_url(f"sim:projector?projected={tmp_path}/noise.png")) as kinect,
        pytest.raises(UserError, match="cannot read"),
    ):
        for _ in range(20):
            kinect.read(0.5)


def test_a_played_finger_appears_in_the_next_frames():
    with VirtualKinect(parse_sim_url("sim:hand?noise=0&drop=0"), colour=False) as kinect:
        empty = first(kinect).depth.astype(int)
        kinect.command((2, 1, 150.0, 100.0, 0.0, 100.0))
        end = time.monotonic() + PATIENCE_S
        while time.monotonic() < end:
            seen = kinect.read(0.5)
            if seen is not None and (seen.depth.astype(int) - empty < -30).sum() > 3000:
                return
    raise AssertionError("the finger never appeared")


PARENT = """
import sys, time
from halo_service.virtual.live import VirtualKinect
from halo_service.virtual.sim_url import parse_sim_url
if __name__ == "__main__":
    kinect = VirtualKinect(parse_sim_url("sim:idle"), colour=False)
    while kinect.read(0.5) is None:
        pass
    print(kinect._process.pid, flush=True)
    {then}
"""


@pytest.mark.parametrize("then", ["time.sleep(60)", "sys.exit(0)", "raise SystemExit(3)"])
def test_the_worker_dies_with_its_parent_however_that_ends(tmp_path, then):
    script = tmp_path / "parent.py"
    script.write_text(PARENT.format(then=then))
    parent = subprocess.Popen(
        [sys.executable, str(script)], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )
    worker = int(parent.stdout.readline())
    if "sleep" in then:
        assert alive(worker)
        parent.kill()
    parent.communicate(timeout=10)
    assert gone(worker)


CLOSED_TERMINAL = """
import os, signal, sys, time
from halo_service.app.process import stop_on_signals
signal.signal(signal.SIGHUP, signal.SIG_DFL)  # these tests, too, may run under nohup
from halo_service.virtual.live import VirtualKinect
from halo_service.virtual.sim_url import parse_sim_url
if __name__ == "__main__":
    stopped = []
    stop_on_signals(lambda: stopped.append(True))
    with VirtualKinect(parse_sim_url("sim:idle"), colour=False) as kinect:
        while kinect.read(0.5) is None:
            pass
        print(kinect._process.pid, kinect._memory.name, flush=True)
        while not stopped:
            kinect.read(0.1)
    print("ended", flush=True)
"""


@pytest.mark.skipif(sys.platform != "linux", reason="shared memory is a file on Linux")
def test_a_terminal_that_closes_leaves_no_worker_and_no_shared_memory(tmp_path):
    script = tmp_path / "parent.py"
    script.write_text(CLOSED_TERMINAL)
    parent = subprocess.Popen(
        [sys.executable, str(script)], stdout=subprocess.PIPE, text=True, start_new_session=True
    )
    pid, memory = parent.stdout.readline().split()
    assert Path("/dev/shm", memory).exists()
    os.killpg(parent.pid, signal.SIGHUP)  # as the system does, to the whole group
    said, _ = parent.communicate(timeout=20)
    assert (parent.returncode, said.strip()) == (0, "ended")
    assert gone(int(pid))
    assert not Path("/dev/shm", memory).exists()
