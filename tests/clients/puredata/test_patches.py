"""`[halo]` of Pure Data reports the touches of the golden vectors, and a hit makes a drum sound."""

from __future__ import annotations

import json
import socket
import subprocess
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from tests.golden import VECTORS

FOLDER = Path(__file__).parents[3] / "clients" / "puredata"
LONGEST_S = 1.0
"""Golden vectors that last longer are left out: Pure Data has its own clock."""
LEFT_OUT = "parts-of-different-frames"
"""Two fingers in one slot; `[halo]` has its state by slot."""
ASSEMBLY = [
    vector
    for vector in json.loads((VECTORS / "assembly.json").read_text())["vectors"]
    if vector["steps"][-1]["at_s"] <= LONGEST_S and vector["name"] != LEFT_OUT
]
STARTED = "started"


class Pd:
    """A running Pure Data; `lines()` are what it has printed since."""

    def __init__(self, program: str, patch: Path, output: Path) -> None:
        self._output = output
        with output.open("w") as file:
            command = [program, "-nogui", "-noaudio", "-stderr", "-path", str(FOLDER)]
            self._process = subprocess.Popen([*command, "-open", str(patch)], stderr=file)

    def lines(self) -> list[str]:
        return self._output.read_text().splitlines()

    def until(self, condition: Callable[[list[str]], bool], patience_s: float = 30.0) -> None:
        end_s = time.monotonic() + patience_s
        while not condition(self.lines()):
            assert time.monotonic() < end_s, "\n".join(self.lines()[-20:])
            time.sleep(0.02)

    def close(self) -> None:
        self._process.terminate()
        self._process.wait(timeout=10)


@pytest.fixture
def pd(tmp_path: Path, external_program: Callable[[str], str]) -> Iterator[Callable[[str], Pd]]:
    """`pd(patch)` opens the text of a patch."""
    opened = []

    def start(text: str) -> Pd:
        patch = tmp_path / "patch.pd"
        patch.write_text(text)
        opened.append(Pd(external_program("pd"), patch, tmp_path / "printed.txt"))
        opened[-1].until(lambda lines: f"{STARTED}: bang" in lines)
        return opened[-1]

    yield start
    for each in opened:
        each.close()


def patch_of(
    boxes: list[str], wires: list[tuple[int, int, int, int]], message: str = "bang"
) -> str:
    """A patch that prints when it has loaded; its last box is a message, sent by its loadbang."""
    started = len(boxes)
    boxes = [*boxes, "loadbang", f"print {STARTED}"]
    wires = [*wires, (started, 0, started + 1, 0)]
    lines = ["#N canvas 0 0 450 300 12;", *(f"#X obj 0 0 {box};" for box in boxes)]
    lines.append(f"#X msg 0 0 {message};")
    lines += [f"#X connect {' '.join(map(str, wire))};" for wire in wires]
    return "\n".join(lines) + "\n"


def test_touches_are_those_of_the_golden_vectors(
    pd: Callable[[str], Pd], free_ports: Callable[[int], list[int]]
) -> None:
    """Each vector goes to a `[halo PORT]` of its own, at the pace of its steps."""
    ports = free_ports(len(ASSEMBLY))
    boxes, wires = [], []
    for number, port in enumerate(ports):
        boxes += [f"halo {port}", f"print down-{number}", f"print up-{number}"]
        wires += [(3 * number, outlet, 3 * number + 1 + outlet, 0) for outlet in (0, 1)]
    program = pd(patch_of(boxes, wires))
    wanted = {n: expected(vector) for n, vector in enumerate(ASSEMBLY)}
    send_at_their_times(ports)
    count = sum(map(len, wanted.values()))
    program.until(lambda lines: sum(line.startswith(("down-", "up-")) for line in lines) >= count)
    time.sleep(0.1)  # Not one more than that.
    found: dict[int, list[Any]] = {n: [] for n in wanted}
    for line in program.lines():
        name, _, values = line.partition(": ")
        if name.startswith(("down-", "up-")):
            kind, _, number = name.partition("-")
            found[int(number)].append((kind, *map(float, values.split())))
    for number, vector in enumerate(ASSEMBLY):
        assert found[number] == wanted[number], vector["name"]


def expected(vector: dict[str, Any]) -> list[tuple[Any, ...]]:
    return [
        (event["kind"], *(event[name] for name in ("slot", "u", "v")))
        + ((event["strike_mm_s"],) if event["kind"] == "down" else ())
        for step in vector["steps"]
        for frame in step.get("events", [])
        if frame["kind"] == "frame"
        for event in frame["events"]
    ]


def send_at_their_times(ports: list[int]) -> None:
    """All vectors in parallel; what our readers refuse as a whole is left out."""
    steps = sorted(
        (step["at_s"], number, step["hex"])
        for number, vector in enumerate(ASSEMBLY)
        for step in vector["steps"]
        if step["hex"] and "refusal" not in step
    )
    start_s = time.monotonic()
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender:
        for at_s, number, raw in steps:
            time.sleep(max(0.0, start_s + at_s - time.monotonic()))
            sender.sendto(bytes.fromhex(raw), ("127.0.0.1", ports[number]))


def test_a_hit_makes_a_drum_sound(
    pd: Callable[[str], Pd], free_port: int, udp_service: Callable[..., Any]
) -> None:
    """The help patch and the drum patch load; without a sound device Pd computes sound, too."""
    boxes = [f"halo-drums {free_port}", "r halo-drums-level", "print level", "halo-help"]
    program = pd(patch_of([*boxes, "s pd"], [(1, 0, 2, 0), (5, 0, 7, 0), (7, 0, 4, 0)], "dsp 1"))
    udp_service(free_port).tap()
    program.until(lambda lines: any(level > 60.0 for level in levels(lines)))
    program.until(lambda lines: levels(lines)[-1] < 20.0)
    assert not [line for line in program.lines() if "couldn't create" in line or "failed" in line]


def levels(lines: list[str]) -> list[float]:
    return [float(line.split()[1]) for line in lines if line.startswith("level: ")]


@pytest.fixture
def free_ports() -> Callable[[int], list[int]]:
    def find(count: int) -> list[int]:
        probes = [socket.socket(socket.AF_INET, socket.SOCK_DGRAM) for _ in range(count)]
        for probe in probes:
            probe.bind(("127.0.0.1", 0))
        ports = [int(probe.getsockname()[1]) for probe in probes]
        for probe in probes:
            probe.close()
        return ports

    return find
