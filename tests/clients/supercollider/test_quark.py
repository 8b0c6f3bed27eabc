"""The Quark reports the touches of the golden vectors, and its example sends sound."""

from __future__ import annotations

import json
import re
import socket
import subprocess
import threading
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import pytest

from halo_protocol import parse_osc
from tests.clients.patchers import QUARK, start_sclang
from tests.golden import VECTORS

EXAMPLE = QUARK / "Examples" / "pressure_and_hover.scd"
ASSEMBLY = json.loads((VECTORS / "assembly.json").read_text())["vectors"]
PATIENCE_S = 60.0
PROGRAM = r"""
(
~print = { |touch|
    "touch % % % % % % %\n".postf(touch[\kind], touch[\id], touch[\slot], touch[\u], touch[\v],
        touch[\strike_mm_s], touch[\contacts])
};
~vectors = VECTORS;
~vectors.do { |vector|
    var fingers = HaloFingers.new;
    vector.do { |step|
        fingers.expire(step[0]).do(~print);
        step[1].do { |message| fingers.receive(message, step[0]).do(~print) };
    };
    "end %\n".postf(fingers.bad);
};
s.addr = NetAddr("127.0.0.1", SERVER_PORT);
Halo.defaultPort = PORT;
BLOCKS
"listening".postln;
)
"""


@pytest.fixture
def sclang(
    tmp_path: Path, external_program: Callable[[str], str]
) -> Iterator[Callable[[str], subprocess.Popen[str]]]:
    """Start sclang with the Quark installed and a program."""
    with ExitStack() as stack:

        def start(text: str) -> subprocess.Popen[str]:
            process = start_sclang(external_program("sclang"), tmp_path, text)
            end = threading.Timer(PATIENCE_S, process.kill)
            end.start()
            stack.callback(process.communicate)
            stack.callback(process.kill)
            stack.callback(end.cancel)
            return process

        yield start


def test_the_class_and_the_example(
    sclang: Callable[[str], subprocess.Popen[str]],
    udp_service: Callable[..., Any],
    free_port: int,
) -> None:
    """One start of sclang for both: it takes a second."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as server:
        server.bind(("127.0.0.1", 0))
        server.settimeout(PATIENCE_S)
        names = {"SERVER_PORT": str(server.getsockname()[1]), "PORT": str(free_port)}
        program = sclang(program_text(names))
        assert program.stdout is not None
        lines = iter(program.stdout)
        for vector in ASSEMBLY:
            assert touches_of(lines) == expected(vector), vector["name"]
        until(lines, "listening")
        service = udp_service(free_port)
        service.tap()
        assert until(lines, "hit: slot 0").strip() == "hit: slot 0, 210.0 mm/s"
        check_sounds([command(server.recv(65_536)) for _ in range(4)])


def program_text(names: dict[str, str]) -> str:
    """The program, with the two blocks of the example. The test is the sound server."""
    blocks = re.findall(r"^\((.*?)^\)$", EXAMPLE.read_text(), re.MULTILINE | re.DOTALL)
    code = "".join(blocks).replace("s.boot;", "")
    vectors = "[" + ",\n".join(in_sclang(vector) for vector in ASSEMBLY) + "]"
    text = PROGRAM.replace("BLOCKS", code).replace("VECTORS", vectors)
    for name, value in names.items():
        text = text.replace(name, value)
    return text


def in_sclang(vector: dict[str, Any]) -> str:
    steps = []
    for step in vector["steps"]:
        raw = None if "refusal" in step else step["hex"]
        messages = parse_osc(bytes.fromhex(raw)) if raw else []
        lists = [", ".join(map(literal, (address, *rest))) for address, rest in messages]
        steps.append(f"[{step['at_s']}, [{', '.join(f'[{each}]' for each in lists)}]]")
    return f"[{', '.join(steps)}]"


def literal(value: Any) -> str:
    return f"'{value}'" if isinstance(value, str) else repr(value)


def touches_of(lines: Iterator[str]) -> list[list[Any]]:
    """The touches that are printed for one vector; no message was refused."""
    found = []
    for line in lines:
        kind, *values = line.split() or [""]
        if kind == "touch":
            found.append([values[0], *map(float, values[1:])])
        if kind == "end":
            assert values == ["0"]
            return found
    raise AssertionError("sclang has ended")


def expected(vector: dict[str, Any]) -> list[list[Any]]:
    names = ("kind", "id", "slot", "u", "v", "strike_mm_s", "contacts")
    return [
        [{"strike_mm_s": -1.0, **event}[name] for name in names]
        for step in vector["steps"]
        for frame in step.get("events", [])
        if frame["kind"] == "frame"
        for event in frame["events"]
    ]


def until(lines: Iterator[str], words: str) -> str:
    for line in lines:
        assert "ERROR" not in line, line
        if words in line:
            return line
    raise AssertionError(f"sclang has ended without {words}")


def command(raw: bytes) -> tuple[str, tuple[Any, ...]]:
    """A command to a sound server; its address is a number, in four bytes."""
    names = {9: b"/s_new\0\0", 15: b"/n_set\0\0"}
    (message,) = parse_osc(names[int.from_bytes(raw[:4], "big")] + raw[4:])
    return message


def check_sounds(sent: list[tuple[str, tuple[Any, ...]]]) -> None:
    """A voice begins with the hovering finger, follows its press and ends with it."""
    (address, (name, voice, *_)) = sent[0]
    assert (address, name) == ("/s_new", "haloFinger")
    assert [(address, rest[0]) for address, rest in sent[1:]] == [("/n_set", voice)] * 3
    set_to = [dict(zip(rest[1::2], rest[2::2], strict=True)) for _, rest in sent[1:]]
    assert [values.get("pressure") for values in set_to] == [0.625, 0.0, None]
    assert set_to[-1] == {"gate": 0}
