"""Draw what the TouchDesigner script builds, and what its network shows for one frame.

    uv run python -m docs.touchdesigner

Writes clients/touchdesigner/network.svg and surface.svg. The script and its callbacks run here with
a stand-in for TouchDesigner, which records operators, parameters and tables.
"""

from __future__ import annotations

import contextlib
import fnmatch
import io
import math
import sys
import types
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from docs.drawings import GREY, INK, Point, Svg
from halo_protocol import Down, Frame, Pointer, encode_frame, parse_osc

FOLDER = Path(__file__).parents[1] / "clients" / "touchdesigner"
FAMILIES = {"CHOP": "#cfe8cf", "DAT": "#e6d9f2", "TOP": "#d6e0f7"}
WIDTH_PX, HEIGHT_PX = 1920, 1080


class Parameter:
    """A value or an expression."""

    def __init__(self, val: Any = None) -> None:
        self.val, self.expr = val, ""


class Parameters:
    """`par` of an operator; setting a value on it works as in TouchDesigner."""

    def __setattr__(self, name: str, value: Any) -> None:
        getattr(self, name).val = value

    def __getattr__(self, name: str) -> Parameter:
        parameter: Parameter = self.__dict__.setdefault(name, Parameter())
        return parameter


class Operator:
    """An operator of the stand-in."""

    def __init__(self, kind: str, name: str, parent: Operator | None) -> None:
        self.kind, self.name, self._parent = kind, name, parent
        self.par, self.nodeX, self.nodeY, self.text = Parameters(), 0, 0, ""
        self.children: dict[str, Operator] = {}
        self.rows: list[list[Any]] = []
        self.wires: dict[int, Operator] = {}
        self._module: Any = None
        for name in ("x", "y"):
            for corner in range(1, 5):
                getattr(self.par, f"extractp{corner}{name}")

    def create(self, kind: str, name: str) -> Operator:
        self.children[name] = Operator(kind, name, self)
        return self.children[name]

    def op(self, name: str) -> Operator | None:
        return self.children.get(name)

    def parent(self) -> Operator | None:
        return self._parent

    def destroy(self) -> None:
        assert self._parent is not None
        del self._parent.children[self.name]

    def pars(self, pattern: str) -> list[Parameter]:
        names = fnmatch.filter(self.par.__dict__, pattern)
        return [self.par.__dict__[name] for name in names]

    @property
    def inputConnectors(self) -> Connectors:  # noqa: N802 - TouchDesigner's name
        return Connectors(self)

    @property
    def module(self) -> Any:
        if self._module is None:
            assert self._parent is not None
            self._module = types.ModuleType(self.name)
            self._module.__dict__.update(me=self, op=self._parent.op, absTime=TIME)
            exec(self.text, self._module.__dict__)
        return self._module

    # Tables.
    def clear(self) -> None:
        self.rows = []

    def appendRow(self, values: Sequence[Any]) -> None:  # noqa: N802
        self.rows.append([str(value) for value in values])

    def deleteRow(self, number: int) -> None:  # noqa: N802
        del self.rows[number]

    @property
    def numRows(self) -> int:  # noqa: N802
        return len(self.rows)

    def _column(self, column: int | str) -> int:
        return self.rows[0].index(column) if isinstance(column, str) else column

    def __getitem__(self, place: tuple[int, int | str]) -> str:
        return str(self.rows[place[0]][self._column(place[1])])

    def __setitem__(self, place: tuple[int, int | str], value: Any) -> None:
        self.rows[place[0]][self._column(place[1])] = str(value)


class Connectors:
    """The inputs of an operator."""

    def __init__(self, owner: Operator, number: int = 0) -> None:
        self._owner, self._number = owner, number

    def __getitem__(self, number: int) -> Connectors:
        return Connectors(self._owner, number)

    def connect(self, source: Operator) -> None:
        self._owner.wires[self._number] = source


TIME = types.SimpleNamespace(seconds=0.0)


COMMAND = f"from pathlib import Path; folder = Path({str(FOLDER)!r}); "
COMMAND += "exec((folder / 'build.py').read_text())"


def built(command: str = COMMAND) -> Operator:
    """Run the script as the Textport does; return the network `/project1/halo`."""
    project = Operator("baseCOMP", "project1", None)
    scope: dict[str, Any] = {"op": {"/project1": project}.get}
    exec(command, scope)
    halo = project.op("halo")
    assert halo is not None
    return halo


def receive(halo: Operator, datagram: bytes) -> None:
    """Pass a datagram to the callbacks, message by message, as an OSC In DAT does."""
    frames_in, callbacks = halo.op("frames_in"), halo.op("callbacks")
    assert frames_in is not None and callbacks is not None
    for address, arguments in parse_osc(datagram):
        callbacks.module.onReceiveOSC(
            frames_in, 1, "", b"", TIME.seconds, address, list(arguments), None
        )


def circle(halo: Operator, slot: int) -> dict[str, float]:
    """The parameters of a slot's circle, from its expressions."""
    finger = halo.op(f"finger{slot}")
    assert finger is not None
    me = types.SimpleNamespace(width=WIDTH_PX, height=HEIGHT_PX)
    scope = {"op": halo.op, "me": me}
    return {
        name: float(eval(parameter.expr, scope))
        for name, parameter in finger.par.__dict__.items()
        if parameter.expr
    }


def example() -> bytes:
    """One frame: an index finger presses, a thumb hovers."""
    header = Frame("desk", "s1", 7, 1_700_000_000, 0, 2)
    press = Pointer(4, 0, 2, 1, 1, 0.3, 0.6, 90.0, 120.0, 0.0, 0.8, 0.0, 0.0, 0.9, 1, 140.0)
    hover = Pointer(5, 1, 2, 0, 0, 0.55, 0.35, 165.0, 70.0, 12.0, 0.0, 0.0, 0.0, 0.9, 0, -1.0)
    down = Down(4, 0, 0.3, 0.6, 180.0, 10.0, 1)
    return encode_frame("table", header, [press, hover], [down])[0]


def draw_network(halo: Operator) -> Svg:
    """Each operator at its place, with its wires."""
    svg = Svg(960, 530)
    nodes = list(halo.children.values())
    left, top = min(node.nodeX for node in nodes), max(node.nodeY for node in nodes)
    corner = {
        node.name: (30 + 0.85 * (node.nodeX - left), 30 + 0.7 * (top - node.nodeY))
        for node in nodes
    }
    for node in nodes:
        for source in node.wires.values():
            (x, y), (x0, y0) = corner[node.name], corner[source.name]
            svg.line((x0 + 88, y0 + 25), (x, y + 25), GREY)
    for node in nodes:
        x, y = corner[node.name]
        fill = next(fill for family, fill in FAMILIES.items() if node.kind.endswith(family))
        svg.polygon(rectangle(x, y, 88, 50), fill)
        svg.text((x + 44, y + 21), node.name, size=12, weight="bold")
        port = node.par.port.val
        svg.text((x + 44, y + 38), f"UDP {port}" if port else node.kind, GREY, size=10)
    return svg


def draw_surface(halo: Operator) -> Svg:
    """The picture of the TOP `surface`, and the two tables."""
    svg = Svg(960, 600)
    left, top, wide, high = 200.0, 40.0, 512.0, 288.0
    svg.text((left, top - 12), "TOP surface", anchor="start", weight="bold")
    svg.polygon(rectangle(left, top, wide, high), "black")
    for slot in range(10):
        at = circle(halo, slot)
        centre = (left + (0.5 + at["centerx"]) * wide, top + (0.5 - at["centery"]) * high)
        red, green, blue = (round(255 * at[f"fillcolor{name}"]) for name in "rgb")
        if at["radiusx"] > 0:
            svg.polygon(ring(centre, at["radiusx"] * wide), f"rgb({red},{green},{blue})")
    for name, row_count, below in (("pointers", 4, 370.0), ("hits", 2, 530.0)):
        table = halo.op(name)
        assert table is not None
        svg.text((30, below), f"DAT {name}", anchor="start", weight="bold")
        for number, row in enumerate(table.rows[:row_count]):
            for column, value in enumerate(row):
                at_text = (30 + 90 * column, below + 24 + 20 * number)
                svg.text(at_text, value, INK if number else GREY, size=12, anchor="start")
    return svg


def rectangle(x: float, y: float, wide: float, high: float) -> list[Point]:
    return [(x, y), (x + wide, y), (x + wide, y + high), (x, y + high)]


def ring(centre: Point, radius: float) -> list[Point]:
    angles = [2 * math.pi * n / 32 for n in range(32)]
    return [(centre[0] + radius * math.cos(a), centre[1] + radius * math.sin(a)) for a in angles]


def main(folder: Path = FOLDER) -> None:
    """Write both drawings."""
    with contextlib.redirect_stdout(io.StringIO()):  # The script and `on_touch` print.
        halo = built()
        receive(halo, example())
    draw_network(halo).write(folder / "network.svg")
    draw_surface(halo).write(folder / "surface.svg")


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else FOLDER)
