"""What the script for TouchDesigner builds, and what it does with datagrams; with a stand-in."""

from __future__ import annotations

import contextlib
import json
from pathlib import Path
from typing import Any

import pytest

from docs import touchdesigner
from halo_protocol import Homography, ProtocolError, Scene, encode, parse_osc
from tests.golden import VECTORS

FOLDER = touchdesigner.FOLDER
CALLBACKS: dict[str, Any] = {}
exec((FOLDER / "halo_callbacks.py").read_text(encoding="utf-8"), CALLBACKS)
ASSEMBLY = json.loads((VECTORS / "assembly.json").read_text())["vectors"]


@pytest.mark.parametrize("vector", ASSEMBLY, ids=lambda vector: str(vector["name"]))
def test_touches_are_those_of_the_golden_vectors(vector: dict[str, Any]) -> None:
    fingers, found, wanted = CALLBACKS["Fingers"](), [], []
    for step in vector["steps"]:
        found += fingers.expire(step["at_s"])
        for address, arguments in messages(step):
            found += fingers.receive(address, arguments, step["at_s"])
        wanted += expected(step)  # At the latest: it does not wait for the last part of a frame.
        assert [reported(touch) for touch in found][: len(wanted)] == wanted
    assert len(found) == len(wanted)
    assert fingers.bad == 0


def messages(step: dict[str, Any]) -> list[Any]:
    """TouchDesigner reads a datagram; what our readers refuse as a whole is not passed on."""
    if step["hex"] is None or "refusal" in step:
        return []
    return parse_osc(bytes.fromhex(step["hex"]))


def reported(touch: Any) -> tuple[Any, ...]:
    return (touch.kind, touch.id, touch.slot, touch.u, touch.v, touch.strike_mm_s, touch.contacts)


def expected(step: dict[str, Any]) -> list[tuple[Any, ...]]:
    names = ("kind", "id", "slot", "u", "v", "strike_mm_s", "contacts")
    return [
        tuple({"strike_mm_s": -1.0, **event}[name] for name in names)
        for frame in step.get("events", [])
        if frame["kind"] == "frame"
        for event in frame["events"]
    ]


def test_after_broken_messages_the_next_frame_is_right() -> None:
    fingers = CALLBACKS["Fingers"]()
    show(fingers, touchdesigner.example(), 0.0)
    shown = fingers.rows()
    count = 0
    for vector in json.loads((VECTORS / "malformed.json").read_text())["vectors"]:
        with contextlib.suppress(ProtocolError):  # TouchDesigner reads no messages from it either.
            for address, arguments in parse_osc(bytes.fromhex(vector["hex"])):
                count += 1
                fingers.receive(address, arguments, 0.1)
                fingers.receive(address, arguments[:1], 0.1)
                fingers.receive(address, [None, *arguments], 0.1)
    assert count > 20
    assert fingers.bad > 20
    show(fingers, touchdesigner.example(), 2.0)
    assert fingers.rows() == shown


def show(fingers: Any, datagram: bytes, now_s: float) -> None:
    for address, arguments in parse_osc(datagram):
        fingers.receive(address, arguments, now_s)


def test_the_corner_pin_undoes_the_homography() -> None:
    """The homography maps each pin, as a place on the surface, to a corner of the projector."""
    matrix = (6.5, 0.125, -40.0, -0.0625, 6.25, 12.5, 0.0009765625, -0.00048828125, 1.0)
    halo = touchdesigner.built()
    scene = Scene("desk", "s1", "1.0.0", 300.0, 200.0, 2, 3, 0, 30.0, 4257, 0)
    touchdesigner.receive(halo, touchdesigner.example())
    touchdesigner.receive(halo, encode("table", scene))
    touchdesigner.receive(halo, encode("table", Homography("desk", "s1", 3, 1920, 1080, matrix)))
    projector = halo.op("projector")
    assert projector is not None
    a, b, c, d, e, f, g, h, i = matrix
    for number, corner in {1: (0, 0), 2: (1920, 0), 3: (0, 1080), 4: (1920, 1080)}.items():
        u, from_below = (projector.pars(f"extractp{number}{axis}")[0].val for axis in "xy")
        x, y = 300 * u, 200 * (1 - from_below)
        w = g * x + h * y + i
        assert ((a * x + b * y + c) / w, (d * x + e * y + f) / w) == pytest.approx(corner, abs=1e-6)


def test_a_homography_of_an_older_calibration_is_not_used() -> None:
    fingers = CALLBACKS["Fingers"]()
    scene = Scene("desk", "s1", "1.0.0", 300.0, 200.0, 2, 4, 0, 30.0, 4257, 0)
    old = Homography("desk", "s1", 3, 1920, 1080, (1.0, 0, 0, 0, 1.0, 0, 0, 0, 1.0))
    for datagram in (touchdesigner.example(), encode("table", scene), encode("table", old)):
        show(fingers, datagram, 0.0)
    assert fingers.pins is None


def test_the_line_of_the_readme_builds_a_network_that_shows_fingers(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    readme = (FOLDER / "README.md").read_text(encoding="utf-8")
    (line,) = [
        line for line in readme.splitlines() if "build.py" in line and line.startswith("from")
    ]
    path = line.split("'")[1]
    halo = touchdesigner.built(line.replace(path, str(FOLDER)))
    touchdesigner.receive(halo, touchdesigner.example())
    pressing, hovering, absent = (touchdesigner.circle(halo, slot) for slot in range(3))
    assert (pressing["centerx"], pressing["centery"]) == pytest.approx((0.3 - 0.5, 0.5 - 0.6))
    assert pressing["radiusx"] > hovering["radiusx"] > absent["radiusx"] == 0
    assert "down 0 0.3" in capsys.readouterr().out
    monkeypatch.setattr(touchdesigner.TIME, "seconds", 5.0)
    tick = halo.op("tick")
    assert tick is not None
    tick.module.onFrameStart(1)
    assert "up 0" in capsys.readouterr().out
    assert touchdesigner.circle(halo, 0)["radiusx"] == 0


def test_names_of_the_network_are_in_the_readme() -> None:
    readme = (FOLDER / "README.md").read_text(encoding="utf-8")
    for name in touchdesigner.built().children:
        assert f"`{name.rstrip('0123456789')}" in readme


def test_the_drawings_are_up_to_date(tmp_path: Path) -> None:
    touchdesigner.main(tmp_path)
    for name in ("network.svg", "surface.svg"):
        assert (FOLDER / name).read_bytes() == (tmp_path / name).read_bytes(), (
            "run `uv run python -m docs.touchdesigner`"
        )
