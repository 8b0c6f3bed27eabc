"""Write halo.maxpat: numbers for each slot, a slider for the first finger, and its sound.

    python3 clients/max/make_patch.py [FILE]

A Max patcher is JSON: boxes, and lines from an outlet of one to an inlet of another.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

PATCH = Path(__file__).with_name("halo.maxpat")
PORT = 7000
SLOTS = 10
VALUES = ("touch", "u", "v", "hover", "pressure", "strike")
SURFACE = "table"
COLUMN, ROW = 90, 50
INTERFACE = {"comment": (1, 0), "flonum": (1, 2), "toggle": (1, 1), "button": (1, 1)}
INTERFACE |= {"pictslider": (2, 2), "ezdac~": (2, 0)}
"""Boxes that are not an object with text, and their numbers of inlets and outlets."""
Place = tuple[float, float]


class Patcher:
    """Boxes and lines."""

    def __init__(self) -> None:
        self.boxes: list[dict[str, Any]] = []
        self.lines: list[dict[str, Any]] = []

    def object(self, text: str, at: Place, inlets: int, outlets: int) -> str:
        """Add an object that is written with words; return its id."""
        return self._box("newobj", at, inlets, outlets, (7.0 * len(text) + 14.0, 22.0), text)

    def interface(self, kind: str, at: Place, text: str = "", size: Place = (60.0, 22.0)) -> str:
        """Add a number, switch, slider or comment."""
        return self._box(kind, at, *INTERFACE[kind], size, text)

    def connect(self, source: str, outlet: int, destination: str, inlet: int = 0) -> None:
        line = {"source": [source, outlet], "destination": [destination, inlet]}
        self.lines.append({"patchline": line})

    def _box(self, kind: str, at: Place, inlets: int, outlets: int, size: Place, text: str) -> str:
        name = f"obj-{len(self.boxes) + 1}"
        counts = {"numinlets": inlets, "numoutlets": outlets, "outlettype": [""] * outlets}
        box = {"id": name, "maxclass": kind, **counts, "patching_rect": [*at, *size]}
        if text:
            box["text"] = text
        self.boxes.append({"box": box})
        return name

    def text(self) -> str:
        """Return the JSON, with one box or line in each line of text."""
        version = {"major": 8, "minor": 0, "revision": 0, "architecture": "x64", "modernui": 1}
        head = {"fileversion": 1, "appversion": version, "classnamespace": "box"}
        head |= {"rect": [60.0, 90.0, 1500.0, 780.0]}
        parts = [f"{json.dumps(name)}: {json.dumps(value)}" for name, value in head.items()]
        for name, values in (("boxes", self.boxes), ("lines", self.lines)):
            parts.append(f'"{name}": [\n' + ",\n".join(map(json.dumps, values)) + "\n]")
        return '{"patcher": {\n' + ",\n".join(parts) + "\n}}\n"


def patch() -> str:
    """Return the text of the patcher."""
    patcher = Patcher()
    comment(patcher, (20, 10), f"halo serve --osc 127.0.0.1:{PORT}/flat", 420)
    comment(
        patcher,
        (20, 30),
        "Nothing moves? halo test-pattern 127.0.0.1:7000/flat draws a circle.",
        460,
    )
    receive = patcher.object(f"udpreceive {PORT}", (20, 60), 1, 1)
    for column, value in enumerate(("slot", *VALUES, "hit")):
        comment(patcher, (20 + COLUMN * column, 90), value, 60)
    routes = [row(patcher, receive, slot) for slot in range(SLOTS)]
    first_finger(patcher, routes[0])
    return patcher.text()


def comment(patcher: Patcher, at: Place, words: str, width: float) -> None:
    patcher.interface("comment", at, words, (width, 20.0))


def row(patcher: Patcher, receive: str, slot: int) -> str:
    """The values of one slot; returns its `route`."""
    y = 115.0 + ROW * slot
    words = " ".join(f"/halo/1/{SURFACE}/slot/{slot}/{value}" for value in VALUES)
    count = len(VALUES) + 1
    route = patcher.object(f"route {words}", (20, y), count, count)
    patcher.connect(receive, 0, route)
    comment(patcher, (20, y + 24), str(slot), 40)
    for outlet, value in enumerate(VALUES):
        at = (20.0 + COLUMN * (outlet + 1), y + 24)
        number = patcher.interface("toggle" if value == "touch" else "flonum", at)
        patcher.connect(route, outlet, number)
    hit(patcher, route, (20.0 + COLUMN * (len(VALUES) + 1), y + 24))
    return route


def hit(patcher: Patcher, route: str, at: Place) -> None:
    """A bang for each touch: its strike is in three frames, and 0 in all others."""
    change = patcher.object("change 0.", at, 1, 3)
    button = patcher.interface("button", (at[0] + 80, at[1]), size=(22.0, 22.0))
    patcher.connect(route, VALUES.index("strike"), change)
    patcher.connect(change, 1, button)  # Its middle outlet sends when 0 becomes another number.


def first_finger(patcher: Patcher, route: str) -> None:
    """A slider that follows slot 0, and a tone: its place is the pitch, its pressure the level."""
    y = 640.0
    comment(
        patcher,
        (20, y - 22),
        "slot 0: place, and sound (u is the pitch, pressure is the level)",
        480,
    )
    slider = patcher.interface("pictslider", (20, y), size=(120.0, 80.0))
    for inlet, (value, text) in enumerate((("u", "* 127."), ("v", "!- 1."))):
        scaled = patcher.object(text, (160 + 60 * inlet, y), 2, 1)
        patcher.connect(route, VALUES.index(value), scaled)
        if value == "v":  # The slider's 0 is at the bottom, the surface's at the far edge.
            up = patcher.object("* 127.", (160 + 60 * inlet, y + 30), 2, 1)
            patcher.connect(scaled, 0, up)
            scaled = up
        patcher.connect(scaled, 0, slider, inlet)
    pitch = patcher.object("scale 0. 1. 110. 880.", (320, y), 6, 1)
    tone = patcher.object("cycle~", (320, y + 30), 2, 1)
    level = patcher.object("clip 0. 1.", (500, y), 3, 1)
    ramp = patcher.object("pack 0. 30", (500, y + 30), 2, 1)
    line = patcher.object("line~", (500, y + 60), 2, 2)
    product = patcher.object("*~", (320, y + 60), 2, 1)
    quiet = patcher.object("*~ 0.3", (320, y + 90), 2, 1)
    speaker = patcher.interface("ezdac~", (420, y + 80), size=(45.0, 45.0))
    patcher.connect(route, VALUES.index("u"), pitch)
    patcher.connect(pitch, 0, tone)
    patcher.connect(route, VALUES.index("pressure"), level)
    for source, destination in ((level, ramp), (ramp, line)):
        patcher.connect(source, 0, destination)
    patcher.connect(tone, 0, product)
    patcher.connect(line, 0, product, 1)
    patcher.connect(product, 0, quiet)
    patcher.connect(quiet, 0, speaker, 0)
    patcher.connect(quiet, 0, speaker, 1)


if __name__ == "__main__":
    (Path(sys.argv[1]) if len(sys.argv) > 1 else PATCH).write_text(patch(), encoding="utf-8")
