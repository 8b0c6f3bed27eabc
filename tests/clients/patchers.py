"""Starts Pure Data and sclang with our patches and our Quark."""

from __future__ import annotations

import os
import subprocess
import time
from collections.abc import Callable, Sequence
from pathlib import Path

CLIENTS = Path(__file__).parents[2] / "clients"
QUARK = CLIENTS / "supercollider"
STARTED = "started"
Wire = tuple[int, int, int, int]
"""A box and its outlet, a box and its inlet."""


class PureData:
    """A running Pure Data with a patch."""

    def __init__(self, program: str, folder: Path, patch: str) -> None:
        path, self._output = folder / "patch.pd", folder / "printed.txt"
        path.write_text(patch)
        command = [program, "-nogui", "-noaudio", "-stderr", "-path", str(CLIENTS / "puredata")]
        with self._output.open("w") as file:
            self._process = subprocess.Popen([*command, "-open", str(path)], stderr=file)
        self.until(lambda lines: f"{STARTED}: bang" in lines)

    def lines(self) -> list[str]:
        """All that it has printed."""
        return self._output.read_text().splitlines()

    def until(self, condition: Callable[[list[str]], bool], patience_s: float = 30.0) -> None:
        end_s = time.monotonic() + patience_s
        while not condition(self.lines()):
            assert time.monotonic() < end_s, "\n".join(self.lines()[-20:])
            time.sleep(0.02)

    def close(self) -> None:
        self._process.terminate()
        self._process.wait(timeout=10)


def patch_of(boxes: Sequence[str], wires: Sequence[Wire], message: str = "bang") -> str:
    """A patch that prints when it has loaded; its last box is a message, for its loadbang."""
    started = len(boxes)
    boxes = [*boxes, "loadbang", f"print {STARTED}"]
    wires = [*wires, (started, 0, started + 1, 0)]
    lines = ["#N canvas 0 0 450 300 12;", *(f"#X obj 0 0 {box};" for box in boxes)]
    lines.append(f"#X msg 0 0 {message};")
    lines += [f"#X connect {' '.join(map(str, wire))};" for wire in wires]
    return "\n".join(lines) + "\n"


def start_sclang(program: str, folder: Path, text: str) -> subprocess.Popen[str]:
    """Start sclang with the Quark installed, and run a program."""
    config, path = folder / "sclang_conf.yaml", folder / "program.scd"
    config.write_text(f"includePaths:\n  - {QUARK}\n")
    path.write_text(text)
    # It starts Qt, which needs no display and, as root, no sandbox.
    qt = {"QT_QPA_PLATFORM": "offscreen", "QTWEBENGINE_CHROMIUM_FLAGS": "--no-sandbox"}
    return subprocess.Popen(
        [program, "-D", "-l", str(config), str(path)],
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        env=os.environ | qt,
    )
