"""`[halo]` of Pure Data reports the touches of the golden vectors, and a hit makes a drum sound."""

from __future__ import annotations

import json
import socket
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, closing
from pathlib import Path
from typing import Any

import pytest

from tests.clients.patchers import PureData, patch_of
from tests.golden import VECTORS
from tests.ports import free_port

LONGEST_S = 1.0
"""Golden vectors that last longer are left out: Pure Data has its own clock."""
LEFT_OUT = "parts-of-different-frames"
"""Two fingers in one slot; `[halo]` has its state by slot."""
ASSEMBLY = [
    vector
    for vector in json.loads((VECTORS / "assembly.json").read_text())["vectors"]
    if vector["steps"][-1]["at_s"] <= LONGEST_S and vector["name"] != LEFT_OUT
]


@pytest.fixture
def pd(
    tmp_path: Path, external_program: Callable[[str], str]
) -> Iterator[Callable[[str], PureData]]:
    """`pd(patch)` opens the text of a patch."""
    with ExitStack() as stack:

        def start(patch: str) -> PureData:
            return stack.enter_context(closing(PureData(external_program("pd"), tmp_path, patch)))

        yield start


def test_touches_are_those_of_the_golden_vectors(pd: Callable[[str], PureData]) -> None:
    """Each vector goes to a `[halo PORT]` of its own, at the pace of its steps."""
    ports = [free_port() for _ in ASSEMBLY]
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
    pd: Callable[[str], PureData], free_port: int, udp_service: Callable[..., Any]
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
