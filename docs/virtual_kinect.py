"""Draw the pictures of virtual-kinect.md and measure its table.

    uv run python docs/virtual_kinect.py

Writes SVG files into pictures/virtual-kinect and a table into the page: the sensor's curves,
measured on its frames, next to the paper's statements. Takes about a minute; the same code gives
the same bytes.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import matplotlib as mpl

mpl.use("svg")  # before pyplot: no window, no display

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from halo_service.virtual.curves import STATES, THRESHOLD_MM, Bench
from halo_service.virtual.halo import FAMILIES, HaloCurve
from halo_service.virtual.materials import MATERIALS
from halo_service.virtual.room import Room
from halo_service.virtual.statements import ASIDE_DEG, bench, check, regions

PAGE = Path(__file__).parent / "virtual-kinect.md"
FOLDER = Path(__file__).parent / "pictures" / "virtual-kinect"
BEGIN, END = "<!-- measured -->", "<!-- end of measured -->"


def plot(path: Path, titles: Sequence[str]) -> tuple[Figure, list[Axes]]:
    """A figure with a row of plots."""
    figure, axes = plt.subplots(1, len(titles), figsize=(3.4 * len(titles), 2.9))
    flat = list(np.atleast_1d(axes))
    for axis, title in zip(flat, titles, strict=True):
        axis.set_title(title)
        axis.grid(alpha=0.3)
    figure.set_label(path.stem)
    return figure, flat


def save(figure: Figure, path: Path) -> None:
    """Write a figure as SVG text without date or random names."""
    figure.tight_layout()
    figure.savefig(path, metadata={"Date": None, "Creator": None})
    plt.close(figure)
    sys.stdout.write(f"{path}\n")


def height_and_force(folder: Path) -> None:
    """Signal against height and force, for each family of curves."""
    path = folder / "height-and-force.svg"
    figure, (heights, forces) = plot(path, ["signal against height", "signal against force"])
    for family in FAMILIES:
        at = Bench(replace(Room(seed=1), curve=HaloCurve(family=family)))
        mm = np.arange(0.0, 24.5, 1.0)
        heights.plot(mm, [at.signal(h, threshold_mm=4.0) for h in mm], label=f"{family}, above 4")
        grams = np.array([2, 25, 50, 100, 150, 200, 300, 385], dtype=float)
        forces.plot(grams, [at.signal(0.0, f) for f in grams], label=family)
    mm = np.arange(0.0, 24.5, 1.0)
    heights.plot(mm, [bench().signal(h) for h in mm], "k:", label="straight, above 8")
    heights.axvline(20.0, color="grey", lw=0.8)
    heights.set(xlabel="height of the pad, mm", ylabel="sum over the patch, mm")
    forces.set(xlabel="force, g", ylim=(0, None))
    heights.legend(fontsize=7)
    forces.legend(fontsize=7)
    save(figure, path)


def finger_pitch(folder: Path) -> None:
    """The four states against the finger's pitch and yaw."""
    path = folder / "finger.svg"
    figure, (pitch, yaw) = plot(path, ["finger's pitch", "finger's yaw"])
    pitches, yaws = np.arange(0.0, 91.0, 7.5), np.arange(-40.0, 41.0, 10.0)
    for state, (height, force) in STATES.items():
        along = [bench().signal(height, force, pitch_deg=p) for p in pitches]
        pitch.plot(pitches, along, label=state)
        across = [bench().signal(height, force, yaw_deg=y) for y in yaws]
        yaw.plot(yaws, across, label=state)
    pitch.axvspan(15.0, 75.0, color="grey", alpha=0.12)
    pitch.set(xlabel="degrees (grey: where the paper works)", ylabel="sum over the patch, mm")
    yaw.set(xlabel="degrees", ylim=(0, None))
    pitch.legend(fontsize=7)
    save(figure, path)


def camera_place(folder: Path) -> None:
    """Sensing regions against the camera's distance, yaw and pitch, with the paper's limits."""
    path = folder / "camera.svg"
    figure, axes = plot(path, ["distance", "camera's yaw", "camera's pitch"])
    places = (
        ("camera_height_mm", np.array([400, 500, 600, 700, 800, 900, 1000, 1100.0]), 0.0),
        ("camera_yaw_deg", np.arange(0.0, 56.0, 5.0), 0.0),
        ("camera_pitch_deg", np.arange(-45.0, 46.0, 7.5), ASIDE_DEG),
    )
    limits = (
        ((800.0, 0.5), (1000.0, 0.75), (700.0, 0.75)),
        ((25.0, 0.5), (50.0, 0.75), (35.0, 0.75)),
        ((15.0, 0.5), (45.0, 0.75), (45.0, 0.75)),
    )
    for axis, (name, values, yaw), marks in zip(axes, places, limits, strict=True):
        found = [regions(yaw, **{name: float(v)}) for v in values]
        for k, part in enumerate(("hover", "touch", "pressure")):
            axis.plot(values, [getattr(f, part) for f in found], f"C{k}", label=part)
            axis.plot(*marks[k], f"C{k}" + ("v" if part == "hover" else "^"), ms=7)
        axis.set(ylim=(0, 1.6), xlabel=name.replace("camera_", "").replace("_", ", "))
    axes[0].set_ylabel("of straight above at 0.5 m")
    axes[0].legend(fontsize=7)
    save(figure, path)


def materials(folder: Path) -> None:
    """The four states on every material."""
    path = folder / "materials.svg"
    figure, (axis,) = plot(path, ["the four states, by material"])
    for k, state in enumerate(STATES):
        values = [bench(material=m).states()[state] for m in MATERIALS]
        axis.bar(np.arange(len(MATERIALS)) + 0.2 * k - 0.3, values, 0.2, label=state)
    axis.set_xticks(range(len(MATERIALS)), list(MATERIALS), rotation=30)
    axis.set_ylabel(f"sum above {THRESHOLD_MM:g}, mm")
    axis.legend(fontsize=7)
    save(figure, path)


def statements(page: Path) -> None:
    """Measure the table and write it into the page, between its two marks."""
    rows = ["| the paper says | section | wanted | measured | holds |", "|---|---|---|---|---|"]
    for finding in check():
        s = finding.statement
        wanted = f"≥ {s.least:g}" if s.most == float("inf") else f"{s.least:g} to {s.most:g}"
        verdict = "yes" if finding.holds else "**no**"
        measured = f"{finding.value:.3g} {s.unit}".strip()
        rows.append(f"| {s.says} | {s.where} | {wanted} | {measured} | {verdict} |")
    before, _, rest = page.read_text(encoding="utf-8").partition(BEGIN)
    _, _, after = rest.partition(END)
    table = "\n".join(rows)
    page.write_text(f"{before}{BEGIN}\n{table}\n{END}{after}", encoding="utf-8")
    sys.stdout.write(f"{page}\n")


def main() -> None:
    """Draw everything."""
    FOLDER.mkdir(parents=True, exist_ok=True)
    # Same numbers, same bytes: no random names; words stay text.
    mpl.rc("svg", fonttype="none", hashsalt="virtual-kinect")
    mpl.rc("font", size=9)
    statements(PAGE)
    for draw in (height_and_force, finger_pitch, camera_place, materials):
        draw(FOLDER)


if __name__ == "__main__":
    main()
