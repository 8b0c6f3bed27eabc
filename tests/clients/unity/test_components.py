"""The package's components, run with a recording on stand-ins of Unity that were written by hand.

They show that the components agree with each other and with the Python client. How Unity itself
behaves is not tested here.
"""

from __future__ import annotations

import json
import subprocess
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from halo_client import Began, Ended, Moved, Touch, touches
from halo_protocol import (
    Assembler,
    Down,
    Homography,
    Pointer,
    Pose,
    Scene,
    TouchFrame,
    Up,
    event_to_json,
    to_json,
)
from halo_service.app.conformance.script import frame, hands, tap
from tests.clients.unity.conftest import sources

Line = dict[str, Any]
SIZE_MM = np.array([300.0, 200.0])
PICTURE_PX, SCREEN_PX = np.array([1920.0, 1080.0]), np.array([1280.0, 800.0])
PROJECTOR = np.array([[4.0, 0.5, 20.0], [0.25, 4.0, 10.0], [1e-4, 0.0, 1.0]])
ANCHOR = np.array([[0.0, -1.0, 0.0, 50.0], [1.0, 0.0, 0.0, -30.0], [0.0, 0.0, 1.0, 12.0]])
UNITY_FROM_WIRE = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, -1.0, 0.0]])
MARKER = np.array([[0.0, 0.0, 1.0, -3.0], [0.0, 1.0, 0.0, 1.0], [-1.0, 0.0, 0.0, 2.0]])
"""World from marker in Scene.cs: its z points to the world's x, its x to the world's -z."""
RUNNING = "plain", "s1"


def frames() -> list[TouchFrame]:
    """Half a second without fingers, a tap, then twelve fingers; ten have a slot of the device."""
    assembler = Assembler()
    groups = [*tap("plain"), frame("plain", 10, hands(12)), frame("plain", 11)]
    datagrams = [raw for group in groups for raw in group]
    events = [event for raw in datagrams for event in assembler.receive_data(raw, 0.0)]
    found = [event for event in events if isinstance(event, TouchFrame)]
    # In the pause the surface and the camera find their places.
    return [replace(found[0], frame=0, time_us=found[0].time_us - 500_000), *found]


@pytest.fixture(scope="module")
def shown(
    compile_csharp: Callable[..., Path],
    core: Path,
    unity: Path,
    tmp_path_factory: pytest.TempPathFactory,
) -> list[Line]:
    """What the components do with a recording."""
    runtime = sources("Runtime")
    internal = set(sources("Runtime", "Internal"))
    components = [each for each in runtime if each not in internal]
    built = compile_csharp("HaloTouch.dll", components, [core, unity])
    scene = sorted(Path(__file__).with_name("scene").glob("*.cs"))
    program = compile_csharp("Scene.exe", scene, [core, unity, built])
    reports = [
        Scene(*RUNNING, "1.0.0", *SIZE_MM, 2, 3, 2, 30.0, 4257, 0),
        Homography(*RUNNING, 3, *map(int, PICTURE_PX), tuple(PROJECTOR.ravel())),
        Pose(*RUNNING, 3, tuple(ANCHOR.ravel()), tuple(ANCHOR.ravel()), 1),
    ]
    lines = [
        {**to_json(each), "kind": type(each).__name__.lower(), "surface": "table"}
        for each in reports
    ]
    lines += [event_to_json(each) for each in frames()]
    recording = tmp_path_factory.mktemp("scene") / "hands.jsonl"
    recording.write_text("".join(f"{json.dumps(line)}\n" for line in lines))
    done = subprocess.run(
        ["mono", str(program), str(recording)], capture_output=True, text=True, timeout=60
    )
    assert done.returncode == 0, done.stderr
    assert done.stderr == "a handler's own error\n", "reported once; nothing else was lost"
    return [json.loads(line) for line in done.stdout.splitlines()]


def column(shown: list[Line], name: str) -> list[Any]:
    return [line[name] for line in shown if name in line]


def in_order(frame: TouchFrame) -> list[Touch]:
    return sorted(touches(frame), key=lambda touch: isinstance(touch, Moved))


def screen(u: float, v: float) -> list[float]:
    """Pixels of the screen, which shows the projector's picture, from the bottom left."""
    x, y, w = PROJECTOR @ (*(SIZE_MM * (u, v)), 1.0)
    px, py = np.array([x, y]) / w / PICTURE_PX * SCREEN_PX
    return [px, SCREEN_PX[1] - py]


def place(touch: Touch) -> Down | Up | Pointer:
    if isinstance(touch, Began):
        return touch.down
    return touch.up if isinstance(touch, Ended) else touch.pointer


PHASES = {Began: "Began", Moved: "Moved", Ended: "Ended"}


def test_touches_are_those_of_a_touchscreen(shown: list[Line]) -> None:
    expected = [touch for each in frames() for touch in in_order(each)]
    found = [line for line in shown if "touch" in line]
    assert [line["touch"] for line in found] == [PHASES[type(touch)] for touch in expected]
    for line, touch in zip(found, expected, strict=True):
        at = place(touch)
        assert line["id"] == at.id + 1, "0 is no id of a touch"
        assert line["pressure"] == (0.0 if isinstance(touch, Ended) else touch.pointer.pressure)
        assert line["at"] == pytest.approx(screen(at.u, at.v), abs=0.01)


def test_slots_have_height_and_force(shown: list[Line]) -> None:
    expected = []
    for each in frames():
        mine = [pointer for pointer in each.pointers if pointer.slot == 0]
        expected.append([mine[-1].hover_mm, mine[-1].force_g] if mine else [-1, -1])
    assert column(shown, "slots")[: len(expected)] == expected


def world(x_mm: float, y_mm: float, hover_mm: float) -> Any:
    """Metres in the scene, from the wire's matrix and the marker's place."""
    in_marker = UNITY_FROM_WIRE @ (ANCHOR @ (x_mm, y_mm, -hover_mm, 1.0)) / 1000
    return MARKER @ (*in_marker, 1.0)


def test_fingers_are_where_the_marker_says_and_lit_by_their_pixel(shown: list[Line]) -> None:
    known = {(each.frame, p.id): p for each in frames() for p in each.pointers}
    placed = [line for line in shown if "finger" in line]
    assert len(placed) == len(known)
    for line in placed:
        pointer = known[line["frame"], line["finger"]]
        expected = world(pointer.x_mm, pointer.y_mm, pointer.hover_mm)
        assert line["world"] == pytest.approx(expected, abs=1e-5)
        x, y, w = PROJECTOR @ (pointer.x_mm, pointer.y_mm, 1.0)
        pixel = (np.array(line["drawn"]) * (1, -1) + 1) / 2 * PICTURE_PX
        assert pixel == pytest.approx([x / w, y / w], abs=0.05)


def test_events_of_the_inspector(shown: list[Line]) -> None:
    all_frames = frames()
    all_touches = [touch for each in all_frames for touch in touches(each)]
    begun = [touch for touch in all_touches if isinstance(touch, Began)]
    moved = [touch for touch in all_touches if isinstance(touch, Moved)]
    assert column(shown, "strike") == [touch.down.strike_mm_s for touch in begun]
    assert column(shown, "press") == [touch.pointer.pressure for touch in moved]
    assert [len(column(shown, each)) for each in ("down", "up")] == [1, 1]
    u, v = begun[0].down.u, begun[0].down.v
    assert column(shown, "down")[0] == pytest.approx(world(*(SIZE_MM * (u, v)), 0.0), abs=1e-5)
    pointers = [pointer for each in all_frames for pointer in each.pointers]
    assert column(shown, "pointer") == [pointer.id for pointer in pointers]
    assert column(shown, "hover") == [p.hover_mm for p in pointers if not p.touching]


def test_the_end_is_reported(shown: list[Line]) -> None:
    assert column(shown, "status") == ["the recording is over"]
    assert column(shown, "connected") == [False]
    assert column(shown, "lost") == ["plain"]
    assert column(shown, "devices") == [0]
