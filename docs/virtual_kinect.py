"""Draw the pictures of virtual-kinect-facts.md and measure its tables.

    uv run python docs/virtual_kinect.py

Writes SVG files into pictures/virtual-kinect, and prints two tables and writes them into the page:
what is known of the real sensor, and the paper's statements, next to what is measured on frames.
Takes about a minute; the same code gives the same bytes.
"""

from __future__ import annotations

import itertools
import sys
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import matplotlib as mpl

mpl.use("svg")  # before pyplot: no window, no display

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import to_hex
from matplotlib.figure import Figure
from numpy.typing import NDArray

from halo_service.values import Finger
from halo_service.virtual import facts
from halo_service.virtual.curves import STATES, THRESHOLD_MM, Bench, background
from halo_service.virtual.halo import FAMILIES, HaloCurve
from halo_service.virtual.hand import pointing
from halo_service.virtual.materials import MATERIALS
from halo_service.virtual.room import Room
from halo_service.virtual.sensor import Sensor
from halo_service.virtual.sensor_model import SENSORS
from halo_service.virtual.skeleton import FingerPose, posed
from halo_service.virtual.statements import ASIDE_DEG, Finding, bench, check, regions

PAGE = Path(__file__).parent / "virtual-kinect-facts.md"
FOLDER = Path(__file__).parent / "pictures" / "virtual-kinect"


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


STEP_MM, DEEPEST_MM, FIELD_PX, CELL_PX = 2.0, 24.0, 64, 4
"""Of the pictures of a finger: one colour per step; width of a view and size of a pixel."""
NOTHING = "#000000"


def finger_by_sensor(folder: Path) -> None:
    """One finger in its states on the kind and on the true sensor: excess depth, pixel by pixel."""
    path = folder / "finger-by-sensor.svg"
    side = FIELD_PX * CELL_PX + 12
    parts = []
    for row, (name, model) in enumerate(SENSORS.items()):
        views = fingers(replace(Room(), sensor=model))
        for column, (state, excess) in enumerate(views.items()):
            x, y = column * side, row * (side + 16) + 14
            parts.append(f'<text x="{x}" y="{y - 3}">{name}: {state}</text>')
            parts.append(f'<g transform="translate({x} {y}) scale({CELL_PX})">')
            parts += cells(excess)
            parts.append("</g>")
    size = f'width="{side * len(views)}" height="{(side + 16) * len(SENSORS)}"'
    head = (
        f'<svg xmlns="http://www.w3.org/2000/svg" {size} font-family="sans-serif" font-size="12">'
    )
    path.write_text("\n".join([head, *parts, "</svg>", ""]), encoding="utf-8")
    sys.stdout.write(f"{path}\n")


def fingers(room: Room) -> dict[str, NDArray[np.float64]]:
    """(FIELD_PX, FIELD_PX) excess depth around the pad, mm, nan where nothing is measured."""
    sensor = Sensor(room, colour_times=0)
    empty = background([sensor.frame(33_333 * k).depth for k in range(30)])
    views = {}
    for k, (state, (height, force)) in enumerate({"30 mm up": (30.0, 0.0), **STATES}.items()):
        aim = FingerPose(150.0, 100.0, height, force, 45.0, -20.0)
        hand = posed(room.user, pointing(room.user, room.dominant, aim, curl=room.user.curl))
        depth = sensor.frame(10_000_000 + k, [hand]).depth.astype(np.float64)
        pad = sensor.surface.to_camera(hand.pad(Finger.INDEX)[None])
        x, y = sensor.camera.depth.project(pad)[0].round().astype(int)
        box = np.s_[y - 26 : y - 26 + FIELD_PX, x - 32 : x - 32 + FIELD_PX]
        views[state] = np.where(depth > 0, depth - empty, np.nan)[box]
    return views


def cells(excess: NDArray[np.float64]) -> list[str]:
    """One path a colour, made of runs of pixels."""
    with np.errstate(invalid="ignore"):
        level = np.clip(np.round(excess / STEP_MM), -DEEPEST_MM / STEP_MM, DEEPEST_MM / STEP_MM)
    level = np.where(np.isnan(excess), np.inf, level)
    runs: dict[float, str] = {}
    for row, line in enumerate(level):
        ends = [0, *(np.flatnonzero(line[1:] != line[:-1]) + 1), len(line)]
        for start, stop in itertools.pairwise(ends):
            run = f"M{start} {row}h{stop - start}v1h-{stop - start}z"
            runs[float(line[start])] = runs.get(float(line[start]), "") + run
    return [f'<path fill="{colour(key)}" d="{runs[key]}"/>' for key in sorted(runs)]


def colour(level: float) -> str:
    """Blue: nearer than the empty table; red: deeper; black: not measured."""
    if np.isinf(level):
        return NOTHING
    return str(to_hex(plt.get_cmap("RdBu_r")(0.5 + 0.5 * level * STEP_MM / DEEPEST_MM)))


def table(findings: Sequence[Finding], head: tuple[str, str]) -> str:
    """Lines of Markdown."""
    rows = [f"| {head[0]} | {head[1]} | expected | measured | holds |", "|---|---|---|---|---|"]
    for finding in findings:
        s = finding.statement
        expected = f"≥ {s.least:g}" if s.most == float("inf") else f"{s.least:g} to {s.most:g}"
        verdict = "yes" if finding.holds else "**no**"
        measured = f"{finding.value:.3g} {s.unit}".strip()
        rows.append(f"| {s.says} | {s.where} | {expected} | {measured} | {verdict} |")
    return "\n".join(rows)


def write(page: Path, name: str, text: str) -> None:
    """Print a table and put it into the page, between its two marks."""
    begin, end = f"<!-- {name} -->", f"<!-- end of {name} -->"
    before, _, rest = page.read_text(encoding="utf-8").partition(begin)
    _, _, after = rest.partition(end)
    page.write_text(f"{before}{begin}\n{text}\n{end}{after}", encoding="utf-8")
    sys.stdout.write(f"{text}\n\n{page}\n")


def main() -> None:
    """Draw everything."""
    FOLDER.mkdir(parents=True, exist_ok=True)
    # Same numbers, same bytes: no random names; words stay text.
    mpl.rc("svg", fonttype="none", hashsalt="virtual-kinect")
    mpl.rc("font", size=9)
    write(PAGE, "facts", table(facts.check(), ("what is known of the real sensor", "source")))
    write(PAGE, "measured", table(check(), ("the paper says", "section")))
    for draw in (height_and_force, finger_pitch, camera_place, materials, finger_by_sensor):
        draw(FOLDER)


if __name__ == "__main__":
    main()
