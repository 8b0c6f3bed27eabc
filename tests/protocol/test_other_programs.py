"""Independent OSC implementations agree with ours, byte by byte and value by value."""

import json
import shutil
import socket
import subprocess
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from pythonosc.osc_bundle import OscBundle
from pythonosc.osc_bundle_builder import IMMEDIATELY, OscBundleBuilder
from pythonosc.osc_message_builder import OscMessageBuilder

from halo_protocol import parse_osc
from halo_protocol.osc import message_spans

VECTORS = Path(__file__).parents[2] / "protocol" / "vectors"


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
def test_oscdump_prints_what_was_sent(tmp_path: Path) -> None:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.bind(("127.0.0.1", 0))
        port = probe.getsockname()[1]
    expected = [
        (address, tags, len(arguments))
        for datagram in DATAGRAMS
        for address, tags, arguments in types_and_arguments(datagram)
    ]
    output = tmp_path / "oscdump.txt"
    with output.open("w") as file:
        oscdump = subprocess.Popen(["oscdump", "-L", str(port)], stdout=file)
    try:
        printed = _exchange(output, port, len(expected))
    finally:
        oscdump.terminate()
        oscdump.wait(timeout=5)
    words = [line.split() for line in printed]
    assert [(word[1], "".join(word[2:3]), len(word[3:])) for word in words] == expected


def _exchange(output: Path, port: int, count: int) -> list[str]:
    """Send everything once oscdump listens; return the lines with our messages."""
    deadline = time.monotonic() + 10
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender:
        while "/ready" not in output.read_text():  # It does not report when it starts to listen.
            assert time.monotonic() < deadline, "oscdump receives nothing"
            sender.sendto(b"/ready\0\0,\0\0\0", ("127.0.0.1", port))
            time.sleep(0.05)
        for datagram in DATAGRAMS:
            sender.sendto(datagram, ("127.0.0.1", port))
    while output.read_text().count("/halo/") < count and time.monotonic() < deadline:
        time.sleep(0.02)
    return [line for line in output.read_text().splitlines() if "/halo/" in line]
