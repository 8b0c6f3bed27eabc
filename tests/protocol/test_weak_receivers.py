"""Receivers with float32 numbers, or with a clock that is off, get frames right and at once."""

from __future__ import annotations

import shutil
import socket
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import pytest

from halo_protocol import Frame, encode_frame
from tests.ports import free_port

PATCH = Path(__file__).with_name("frame.pd")
PYTHON_OSC = """
import sys
from pythonosc.dispatcher import Dispatcher
from pythonosc.osc_server import BlockingOSCUDPServer

dispatcher = Dispatcher()
dispatcher.set_default_handler(lambda address, *_: print(address, flush=True))
server = BlockingOSCUDPServer(("127.0.0.1", 0), dispatcher)
print(server.server_address[1], flush=True)
server.timeout = 60.0
server.handle_request()  # one datagram, then the end: faketime does not pass signals on
"""


def datagram(number: int, session_ms: int = 0, *, timetagged: bool = False) -> bytes:
    seconds, rest = divmod(time.time_ns() // 1000, 1_000_000)
    header = Frame("desk", "s1", number, seconds, rest, 0, session_ms)
    return encode_frame("table", header, [], timetagged=timetagged)[0]


@pytest.fixture
def send() -> Callable[[int, bytes], None]:
    def to(port: int, raw: bytes) -> None:
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender:
            sender.sendto(raw, ("127.0.0.1", port))

    return to


@pytest.mark.skipif(not shutil.which("pd"), reason="Pure Data is not installed")
def test_pure_data_gets_frame_and_session_time_exactly(
    tmp_path: Path, send: Callable[[int, bytes], None]
) -> None:
    port = free_port()
    patch = tmp_path / "frame.pd"
    patch.write_text(PATCH.read_text().replace("PORT", str(port)))
    output = tmp_path / "pd.txt"
    numbers = [2**24 - 1, 2**24 - 2, 12_345_677, 0]
    with output.open("w") as file:
        pd = subprocess.Popen(
            ["pd", "-nogui", "-noaudio", "-stderr", "-open", str(patch)], stderr=file
        )
    try:
        found: list[tuple[int, int]] = []
        until = time.monotonic() + 30.0
        while len(found) < len(numbers) and time.monotonic() < until:
            wanted = numbers[len(found)]
            send(port, datagram(wanted, (wanted + 7) % 2**24))
            time.sleep(0.2)
            pairs = list(dict.fromkeys(printed(output.read_text())))
            found = pairs
    finally:
        pd.terminate()
        pd.wait(timeout=10)
    assert found == [(number, (number + 7) % 2**24) for number in numbers]


def printed(text: str) -> list[tuple[int, int]]:
    """(frame, session_ms) of each message; the patch prints each number in two halves."""
    lines = [line.split(": ") for line in text.splitlines() if ": " in line]
    values = [
        (name, int(value)) for name, value in lines if name in ("high", "low", "mshigh", "mslow")
    ]
    groups = [dict(values[n : n + 4]) for n in range(0, len(values) - 3, 4)]
    return [(g["high"] * 4096 + g["low"], g["mshigh"] * 4096 + g["mslow"]) for g in groups]


@pytest.mark.skipif(not shutil.which("faketime"), reason="faketime is not installed")
@pytest.mark.parametrize("offset", ["-5s", "+5s"])
def test_a_receiver_with_another_clock_shows_frames_at_once(
    offset: str, send: Callable[[int, bytes], None]
) -> None:
    assert delay_s(offset, send) < 2.0


@pytest.mark.skipif(not shutil.which("faketime"), reason="faketime is not installed")
def test_with_timetags_a_receiver_behind_shows_frames_late(
    send: Callable[[int, bytes], None],
) -> None:
    """Why the timetag is "immediately": this is what the option costs."""
    assert delay_s("-5s", send, timetagged=True) > 3.0


def delay_s(offset: str, send: Callable[[int, bytes], None], *, timetagged: bool = False) -> float:
    """Seconds until python-osc, with its clock off, passes a frame on."""
    command = ["faketime", "-f", offset, sys.executable, "-c", PYTHON_OSC]
    with subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True
    ) as receiver:
        assert receiver.stdout is not None
        try:
            port = int(receiver.stdout.readline())
            started_s = time.monotonic()
            send(port, datagram(1, timetagged=timetagged))
            assert receiver.stdout.readline().startswith("/halo/1/table/")
            return time.monotonic() - started_s
        finally:
            receiver.kill()
