"""Frames wait for no picture, and a picture belongs to the service that is followed."""

from __future__ import annotations

import subprocess
import sys
import threading
import time
from dataclasses import replace
from itertools import pairwise
from typing import Any

import pytest

from halo_client import KnownServices, Receiver
from halo_client.errors import ClientError
from halo_protocol import Frame, Homography, Report, Scene, TouchFrame, encode, encode_frame
from halo_window import listen

SQUARE = (1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0)


class Input:
    """A stream of one frame each 10 ms, with what else is due before it; then it ends or fails."""

    url = "test://"

    def __init__(self, frames: int, error: Exception | None = None) -> None:
        self.remaining, self.error = frames, error

    def receive(self, timeout_s: float) -> tuple[bytes, str] | None:
        time.sleep(0.01)
        if self.remaining == 0:
            if self.error is not None:
                raise self.error
            from halo_client.errors import EndOfStream

            raise EndOfStream
        self.remaining -= 1
        header = Frame("desk", "s1", 1000 - self.remaining, 0, 0, 0)
        return next(iter(encode_frame("table", header, (), (), ()))), "test"

    def close(self) -> None:
        pass


def listened(source: Input, draw_s: float, at_once: bool) -> tuple[list[float], set[str]]:
    """Return when each frame was processed, and in which threads."""
    times: list[float] = []
    threads: set[str] = set()

    def on_frame(frame: TouchFrame, now_s: float) -> None:
        times.append(time.monotonic())
        threads.add(threading.current_thread().name)

    listen(
        "test",
        Receiver(source),
        None,
        on_frame,
        lambda now_s, note: time.sleep(draw_s),
        at_once=at_once,
    )
    return times, threads


@pytest.fixture(autouse=True)
def short(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("halo_window.loop.LINGER_S", 0.1)


def test_while_the_window_is_dragged_sound_goes_on() -> None:
    times, threads = listened(Input(40), draw_s=0.5, at_once=True)
    assert threads == {"receiver"}
    assert len(times) >= 40
    gaps_s = sorted(b - a for a, b in pairwise(times))
    assert gaps_s[len(gaps_s) * 9 // 10] < 0.1  # a picture takes 0.5 s


def test_while_the_window_is_dragged_no_frame_is_lost() -> None:
    times, threads = listened(Input(40), draw_s=0.3, at_once=False)
    assert threads == {"MainThread"}
    assert len(times) >= 40


def test_an_error_of_the_stream_reaches_the_program() -> None:
    with pytest.raises(ClientError, match="line 3 is broken"):
        listened(Input(5, ClientError("line 3 is broken")), draw_s=0.0, at_once=True)
    assert not [each for each in threading.enumerate() if each.name == "receiver"]


def reports(node: str, session: str, width_px: int) -> list[Report]:
    scene = Scene(node, session, "1.0.0", 300.0, 200.0, 2, 1, 0, 30.0)
    return [
        Report("table", scene),
        Report("table", Homography(node, session, 1, width_px, 800, SQUARE)),
    ]


def test_of_two_services_the_followed_one_moves_the_picture() -> None:
    known = KnownServices()
    for report in (*reports("desk", "s1", 1280), *reports("wall", "s2", 1920)):
        known.update(report)
    scene, homography = known.placing(("desk", "table", "s1"))
    assert scene is not None and homography is not None
    assert (scene.node, homography.width_px) == ("desk", 1280)
    newest = known.placing(None)[1]
    assert newest is not None and newest.width_px == 1920


def test_a_clone_of_the_followed_service_moves_nothing() -> None:
    class Queue:
        url = "test://"

        def __init__(self) -> None:
            self.waiting: list[bytes] = []

        def receive(self, timeout_s: float) -> tuple[bytes, str] | None:
            return (self.waiting.pop(0), "test") if self.waiting else None

        def close(self) -> None:
            pass

    source = Queue()
    receiver = Receiver(source)

    def send(*messages: Any) -> list[Any]:
        source.waiting += [encode("table", message) for message in messages]
        events = []
        while source.waiting:
            events += receiver.poll(0.0)
        return events

    header = Frame("desk", "s1", 1, 0, 0, 0)
    source.waiting += list(encode_frame("table", header, (), (), ()))
    receiver.poll(0.0)
    ours = [report.message for report in reports("desk", "s1", 1280)]
    clone = [report.message for report in reports("desk", "s9", 1920)]
    assert len(send(*ours, *clone, *ours, replace(clone[0], width_mm=99.0))) == 4
    scene, homography = receiver.services.placing(receiver.following)
    assert scene is not None and homography is not None
    assert (scene.width_mm, homography.width_px) == (300.0, 1280)


def test_a_sound_file_is_written_without_window_sound_or_midi() -> None:
    script = (
        "import sys\n"
        "for name in ('pygame', 'mido', 'miniaudio'): sys.modules[name] = None\n"
        "from halo_drums.command import main\n"
        "sys.exit(main(['--from', 'nowhere.jsonl', '--render', 'x.wav']))"
    )
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True)
    assert done.returncode == 2
    reason = "cannot read nowhere.jsonl (No such file or directory)"
    assert done.stderr.strip() == f"halo-drums: {reason}"
