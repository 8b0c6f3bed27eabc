"""Independent OSC implementations agree with ours, byte by byte and value by value."""

import ast
import json
import shutil
import socket
import struct
import subprocess
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from pythonosc.osc_bundle import OscBundle
from pythonosc.osc_bundle_builder import IMMEDIATELY, OscBundleBuilder
from pythonosc.osc_message_builder import OscMessageBuilder

from halo_protocol import DEFAULT_PORT, parse_osc
from halo_protocol.osc import message_spans
from tests import ports
from tests.golden import VECTORS


def written() -> Iterator[tuple[str, bytes, float | None]]:
    """Each datagram that we write, by name, with the time of its timetag in s, or None."""
    for vector in json.loads((VECTORS / "frames.json").read_text())["vectors"]:
        for i, part in enumerate(vector["datagrams"]):
            header = part["messages"][0]
            time_s = header["time_s"] + header["time_frac_us"] / 1e6
            time_s = time_s if vector["timetagged"] else None
            yield f"{vector['name']}/{i}", bytes.fromhex(part["hex"]), time_s
    for vector in json.loads((VECTORS / "reports.json").read_text())["vectors"]:
        time_us = vector["time_us"]
        time_s = None if time_us is None else time_us / 1e6
        yield vector["name"], bytes.fromhex(vector["hex"]), time_s


WRITTEN = [pytest.param(*rest, id=name) for name, *rest in written()]
DATAGRAMS = [datagram for _, datagram, _ in written()]


def types_and_arguments(datagram: bytes) -> Iterator[tuple[str, str, tuple[Any, ...]]]:
    """The messages of a datagram, read by the generic reader, which the codec does not use."""
    for (start, end), (address, arguments) in zip(
        message_spans(datagram), parse_osc(datagram), strict=True
    ):
        tags = datagram[start:end].split(b",", 1)[1].split(b"\0", 1)[0].decode()
        yield address, tags, arguments


@pytest.mark.parametrize(("datagram", "time_s"), WRITTEN)
def test_python_osc_writes_the_same_bytes(datagram: bytes, time_s: float | None) -> None:
    # The annotation says int, but it is seconds with a fraction.
    builder = OscBundleBuilder(IMMEDIATELY if time_s is None else time_s)  # type: ignore[arg-type]
    for address, tags, arguments in types_and_arguments(datagram):
        message = OscMessageBuilder(address)
        for tag, argument in zip(tags, arguments, strict=True):
            message.add_arg(argument, tag)
        builder.add_content(message.build())
    theirs = builder.build().dgram
    assert datagram[16:] == theirs[16:]
    ours, other = (int.from_bytes(raw[8:16], "big") for raw in (datagram, theirs))
    # python-osc computes the timetag in float64, whose step is half a microsecond today.
    assert abs(ours - other) <= 2**32 * 1e-6
    if time_s is None or time_s % 0.25 == 0:
        assert datagram == theirs


@pytest.mark.parametrize(("datagram", "time_s"), WRITTEN)
def test_python_osc_reads_equal_values(datagram: bytes, time_s: float | None) -> None:
    found = [(message.address, tuple(message.params)) for message in OscBundle(datagram)]
    assert found == parse_osc(datagram)


def test_liblo_reads_equal_values() -> None:
    liblo = pytest.importorskip("pyliblo3", reason="pyliblo3 is not installed")
    server = liblo.Server(None, proto=liblo.UDP)
    found = []
    server.add_method(None, None, lambda path, arguments: found.append((path, tuple(arguments))))
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender:
        for datagram in DATAGRAMS:
            found.clear()
            sender.sendto(datagram, ("127.0.0.1", server.port))
            expected = parse_osc(datagram)
            for _ in range(100):
                if len(found) < len(expected):
                    server.recv(20)
            assert found == expected
    server.free()


@pytest.mark.skipif(not shutil.which("oscdump"), reason="oscdump is not installed")
def test_oscdump_prints_what_was_sent(tmp_path: Path, free_port: int) -> None:
    expected = [
        (address, tags, len(arguments))
        for datagram in DATAGRAMS
        for address, tags, arguments in types_and_arguments(datagram)
    ]
    command = ["oscdump", "-L", str(free_port)]
    printed = _exchange(command, tmp_path, free_port, len(expected))
    words = [line.split() for line in printed]
    assert [(word[1], "".join(word[2:3]), len(word[3:])) for word in words] == expected


SCLANG = """
thisProcess.addOSCRecvFunc({ |message| message.postcs });
thisProcess.openUDPPort(PORT);
"""


@pytest.mark.skipif(not shutil.which("sclang"), reason="sclang is not installed")
def test_sclang_prints_equal_values(
    tmp_path: Path, free_port: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    # It starts Qt, which needs no display and, as root, no sandbox.
    monkeypatch.setenv("QT_QPA_PLATFORM", "offscreen")
    monkeypatch.setenv("QTWEBENGINE_CHROMIUM_FLAGS", "--no-sandbox")
    program = tmp_path / "receive.scd"
    program.write_text(SCLANG.replace("PORT", str(free_port)))
    expected = [message for datagram in DATAGRAMS for message in parse_osc(datagram)]
    command = ["sclang", "-D", str(program)]
    printed = _exchange(command, tmp_path, free_port, len(expected))
    # A symbol is printed in quotes, so a line is a list in Python's notation, too.
    found = [(address, tuple(rest)) for address, *rest in map(ast.literal_eval, printed)]
    assert found == [(address, pytest.approx(values)) for address, values in expected]


PCAP_HEAD = struct.pack("<IHHiIII", 0xA1B2C3D4, 2, 4, 0, 0, 65_535, 101)
"""A capture of raw IP packets."""
FIELDS = {"header.path": str, "int32": int, "float": float, "string": str}


@pytest.mark.skipif(not shutil.which("tshark"), reason="tshark is not installed")
def test_tshark_dissects_equal_values(tmp_path: Path) -> None:
    capture = tmp_path / "datagrams.pcap"
    capture.write_bytes(PCAP_HEAD + b"".join(map(_captured, DATAGRAMS)))
    command = ["tshark", "-r", str(capture), "--enable-heuristic", "osc_udp", "-T", "fields"]
    command += ["-E", "aggregator=|", "-E", "separator=;"]
    for name in FIELDS:
        command += ["-e", f"osc.message.{name}"]
    done = subprocess.run(command, capture_output=True, text=True, timeout=60)
    assert done.returncode == 0, done.stderr
    for line, datagram in zip(done.stdout.splitlines(), DATAGRAMS, strict=True):
        found = [
            [kind(value) for value in values.split("|") if value]
            for kind, values in zip(FIELDS.values(), line.split(";"), strict=True)
        ]
        messages = parse_osc(datagram)
        arguments = [argument for _, values in messages for argument in values]
        typed = [[each for each in arguments if type(each) is kind] for kind in (int, float, str)]
        assert found[0] == [address for address, _ in messages]
        # It prints six digits of a float.
        assert found[1:] == [typed[0], pytest.approx(typed[1], rel=5e-6), typed[2]]


def _captured(datagram: bytes) -> bytes:
    """A datagram as a packet of a capture file."""
    udp = struct.pack(">HHHH", 50_000, DEFAULT_PORT, 8 + len(datagram), 0) + datagram
    head = struct.pack(">BBHHHBBH", 0x45, 0, 20 + len(udp), 0, 0, 64, socket.IPPROTO_UDP, 0)
    packet = head + socket.inet_aton("127.0.0.1") * 2 + udp
    return struct.pack("<IIII", 0, 0, len(packet), len(packet)) + packet


def _exchange(command: list[str], folder: Path, port: int, count: int) -> list[str]:
    """Start a program, send everything once it listens; return its lines with our messages."""
    output = folder / "printed.txt"
    with output.open("w") as file:
        program = subprocess.Popen(
            command, stdin=subprocess.DEVNULL, stdout=file, stderr=subprocess.DEVNULL
        )
    try:
        deadline = time.monotonic() + 60
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender:
            # Programs do not report when they start to listen.
            while "/ready" not in output.read_text():
                assert time.monotonic() < deadline, f"{command[0]} receives nothing"
                sender.sendto(b"/ready\0\0,\0\0\0", ("127.0.0.1", port))
                time.sleep(0.05)
            for datagram in DATAGRAMS:
                sender.sendto(datagram, ("127.0.0.1", port))
        while output.read_text().count("/halo/") < count and time.monotonic() < deadline:
            time.sleep(0.02)
    finally:
        program.terminate()
        program.wait(timeout=10)
    return [line for line in output.read_text().splitlines() if "/halo/" in line]


@pytest.fixture
def free_port() -> int:
    return ports.free_port()
