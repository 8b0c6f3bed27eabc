"""Draws what nodes report, what the canvas makes of it, and the truth."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import matplotlib as mpl

mpl.use("agg")  # before pyplot: no window, no display

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes

from halo_service.values import Touch, TouchFrame
from halo_service.virtual.clock import clocks_of
from halo_service.virtual.installation.places import AREA_MM, canvas_mm
from halo_service.virtual.sim_url import SimRequest

from .sensed import START_US, lines_of

COLOURS = ("#2457c5", "#d9822b", "#2c8a3d", "#c62f2f", "#8a4fbf", "#6a7480")
"""Of the cameras, and of ids in turn."""
OUTLINE = ((0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0), (0.0, 0.0))


def draw(
    path: Path,
    request: SimRequest,
    streams: Sequence[Path],
    frames: Sequence[TouchFrame],
    truth: Sequence[dict[str, Any]],
    span_s: tuple[float, float],
) -> None:
    """Write a PNG: above the nodes' pointers, below the canvas's, each id in its colour."""
    width, height = canvas_mm(request.room.installation)
    figure, axes = plt.subplots(2, 1, figsize=(8.0, 0.8 + 16.0 * (height + 60.0) / (width + 40.0)))
    for axis, title in zip(axes, ("reported by the cameras", "the canvas"), strict=True):
        _dress(axis, title, request)
        _draw_truth(axis, truth, span_s)
    _draw_nodes(axes[0], request, streams, span_s)
    _draw_canvas(axes[1], frames, span_s)
    figure.tight_layout()
    figure.savefig(path, dpi=90, metadata={"Software": None})
    plt.close(figure)


def _dress(axis: Axes, title: str, request: SimRequest) -> None:
    width, height = canvas_mm(request.room.installation)
    for number in request.room.installation.numbers:
        matrix = request.room.place_of(number).canvas_from_surface
        corners = np.array([[x * AREA_MM[0], y * AREA_MM[1], 0.0, 1.0] for x, y in OUTLINE])
        x, y = (matrix @ corners.T)[:2]
        axis.plot(x, y, color=COLOURS[number - 1], linewidth=1.0)
    axis.set(title=title, xlim=(-15.0, width + 15.0), ylim=(height + 15.0, -15.0))
    axis.set_aspect("equal")
    axis.tick_params(labelsize=8)


def _draw_truth(axis: Axes, truth: Sequence[dict[str, Any]], span_s: tuple[float, float]) -> None:
    for line in truth:
        if not span_s[0] <= line.get("time_us", -1e9) / 1e6 <= span_s[1]:
            continue
        for finger in line["fingers"]:
            if finger["finger"] == "index":
                size = 16.0 if finger["touching"] else 3.0
                axis.scatter(finger["x_mm"], finger["y_mm"], size, "#d5dae0", zorder=0)


def _draw_nodes(
    axis: Axes, request: SimRequest, streams: Sequence[Path], span_s: tuple[float, float]
) -> None:
    clocks = clocks_of(request.room, request.scenario)
    for number, path in enumerate(streams, 1):
        matrix = request.room.place_of(number).canvas_from_surface
        for line in lines_of(path):
            if not span_s[0] <= clocks[number].host_s(line["time_us"]) <= span_s[1]:
                continue
            for each in line["pointers"]:
                x, y = (matrix @ [each["x_mm"], each["y_mm"], 0.0, 1.0])[:2]
                _dot(axis, float(x), float(y), each["state"] != "hover", COLOURS[number - 1])


def _draw_canvas(axis: Axes, frames: Sequence[TouchFrame], span_s: tuple[float, float]) -> None:
    for frame in frames:
        if span_s[0] <= (frame.time_us - START_US) / 1e6 <= span_s[1]:
            for each in frame.pointers:
                colour = COLOURS[each.id % len(COLOURS)]
                _dot(axis, each.x_mm, each.y_mm, each.state is not Touch.HOVER, colour)


def _dot(axis: Axes, x: float, y: float, touching: bool, colour: str) -> None:
    axis.scatter(x, y, 9.0 if touching else 5.0, colour if touching else "none", edgecolors=colour,
                 linewidths=0.6)  # fmt: skip
