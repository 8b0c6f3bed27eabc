"""The sketch of Processing compiles, and its reader shows the fingers that the service sends."""

from __future__ import annotations

import json
import subprocess
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest

from halo_protocol import Down
from halo_service.outputs.formats.flat import FlatFormat
from tests.golden import VECTORS
from tests.outputs.samples import HOVERING, TOUCHING, frame

pytestmark = pytest.mark.long
HERE = Path(__file__).parent
SKETCH = HERE.parents[2] / "clients" / "processing" / "halo_circles"


@pytest.fixture(scope="module")
def java(
    tmp_path_factory: pytest.TempPathFactory, external_program: Callable[[str], str]
) -> Callable[[str], str]:
    """Compile the sketch as Processing does, inside a class; `java(lines)` runs the reader."""
    folder = tmp_path_factory.mktemp("java")
    sketch = (SKETCH / "halo_circles.pde").read_text()
    # Processing writes `public` for its functions and takes numbers as float.
    sketch = sketch.replace("\nvoid ", "\npublic void ").replace("*= 0.9", "*= 0.9f")
    (folder / "halo_circles.java").write_text(f"class halo_circles extends PApplet {{{sketch}}}")
    files = [SKETCH / "HaloFlat.java", HERE / "PApplet.java", HERE / "ReadFlat.java"]
    files.append(folder / "halo_circles.java")
    command = [external_program("javac"), "-Xlint:all", "-Werror", "-d", folder, *files]
    done = subprocess.run(list(map(str, command)), capture_output=True, text=True)
    assert done.returncode == 0, done.stderr

    def read(lines: str) -> str:
        run = subprocess.run(
            [external_program("java"), "-cp", folder, "ReadFlat"],
            input=lines, capture_output=True, text=True, timeout=60,
        )  # fmt: skip
        assert run.returncode == 0, run.stderr
        return run.stdout

    return read


def test_the_reader_shows_what_the_service_sends(java: Callable[[str], str]) -> None:
    """A hit in three frames counts once, also in a split frame of ten fingers."""
    down = Down(7, 0, 0.5, 0.25, 210.0, 12.0, 3)
    ten = tuple(replace(TOUCHING, id=100 + n, slot=n, u=n / 16) for n in range(10))
    frames = [
        frame(0, (HOVERING,)),
        *(frame(n, (TOUCHING,), (down,)) for n in (1, 2, 3)),
        frame(4, ()),
        frame(5, ten),
    ]
    output = FlatFormat()
    per_frame = [[raw.hex() for raw in output.frame(each)] for each in frames]
    lines = java("\n".join(raw for each in per_frame for raw in each) + "\n").splitlines()
    ends, count = [], 0
    for each in per_frame:
        count += len(each)
        ends.append(lines[count - 1].split(";"))
    assert ends[0][0] == "false 0.5 0.25 150.0 8.5 0.0 -1.0 0"
    assert [end[0] for end in ends[1:4]] == ["true 0.5 0.25 150.0 0.0 0.5 80.0 1"] * 3
    assert ends[4][0].split()[0] == "false"
    assert ends[4][0].split()[4] == "-1.0"
    assert [end.split()[1] for end in ends[5][:10]] == [str(n / 16) for n in range(10)]


def test_broken_datagrams_change_nothing(java: Callable[[str], str]) -> None:
    good = FlatFormat().frame(frame(0, (TOUCHING,)))[0].hex()
    broken = json.loads((VECTORS / "malformed.json").read_text())["vectors"]
    cut = [good[: 2 * n] for n in range(0, len(good) // 2, 7)]
    sent = [good, *(each["hex"] for each in broken), *cut]
    shown = java("\n".join(sent) + "\n").splitlines()
    assert len(shown) == len(sent)
    assert set(shown) == {shown[0]}
