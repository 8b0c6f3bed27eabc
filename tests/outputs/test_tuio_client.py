"""The npm package tuio-client shows our fingers, also after a restart and after the last one left.

`npm install` in tests/outputs/tuio_client brings it; the test is skipped without it.
"""

from __future__ import annotations

import json
import shutil
import subprocess
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from pythonosc.osc_bundle import OscBundle

from halo_service.outputs.formats.tuio2 import Tuio2Format
from halo_service.outputs.formats.tuio11 import Tuio11Format
from tests.outputs.samples import fingers, frame

FOLDER = Path(__file__).parent / "tuio_client"
pytestmark = pytest.mark.skipif(
    shutil.which("node") is None or not (FOLDER / "node_modules" / "tuio-client").is_dir(),
    reason="tuio-client is not installed: npm install in tests/outputs/tuio_client",
)


def lines(datagrams: list[bytes]) -> Iterator[str]:
    for raw in datagrams:
        for message in OscBundle(raw):
            args = [_json(each) for each in message.params]
            yield json.dumps({"address": message.address, "args": args})


def _json(argument: Any) -> Any:
    """A timetag as a number; its fraction does not matter to a list of pointers."""
    return 1 if isinstance(argument, tuple) else argument


def shown(*steps: list[bytes]) -> list[dict[str, list[list[float]]]]:
    """What the client shows after each step."""
    text = ""
    for datagrams in steps:
        text += "\n".join([*lines(datagrams), json.dumps({"show": True})]) + "\n"
    done = subprocess.run(
        ["node", "read.js"], cwd=FOLDER, input=text, capture_output=True, text=True, timeout=60
    )
    assert done.returncode == 0, done.stderr
    return [json.loads(line) for line in done.stdout.splitlines()]


def test_tuio11_cursors_come_and_go() -> None:
    tuio = Tuio11Format()
    ten, empty = shown(tuio.frame(frame(1, fingers(10))), tuio.frame(frame(2)))
    assert sorted(ten["cursors"]) == [pytest.approx([n / 20, 0.25]) for n in range(1, 10, 2)]
    assert empty["cursors"] == []


def test_tuio2_pointers_come_and_go() -> None:
    tuio = Tuio2Format()
    ten, empty = shown(tuio.frame(frame(1, fingers(10))), tuio.frame(frame(2)))
    expected = [[n / 20, 0.25, 0.5 if n % 2 else -0.085, 1] for n in range(10)]
    assert sorted(ten["pointers"]) == [pytest.approx(each) for each in expected]
    assert empty["pointers"] == []


@pytest.mark.parametrize(("make", "kind"), [(Tuio11Format, "cursors"), (Tuio2Format, "pointers")])
@pytest.mark.parametrize("ran", [1, 300, 30 * 3600])
def test_after_a_restart_the_client_shows_the_new_fingers(make: Any, kind: str, ran: int) -> None:
    before, again = make(), make()
    old = [before.frame(frame(n, fingers(4))) for n in range(min(ran, 300))]
    before._ids._frame += max(0, ran - 300) * 2  # as many numbers as an hour takes
    old.append(before.frame(frame(ran, fingers(4))))
    steps = [[raw for each in old for raw in each], again.frame(frame(ran + 150, fingers(2)))]
    running, restarted = shown(*steps)
    assert len(running[kind]) == (4 if kind == "pointers" else 2)
    assert len(restarted[kind]) == (2 if kind == "pointers" else 1)


@pytest.mark.parametrize("make", [Tuio11Format, Tuio2Format])
def test_sixty_four_fingers_are_all_shown(make: Any) -> None:
    tuio = make()
    everyone = [tuio.frame(frame(n, fingers(64))) for n in (1, 2)]
    (found,) = shown([raw for each in everyone for raw in each])
    assert len(found["pointers"]) + len(found["cursors"]) == (64 if make is Tuio2Format else 32)
