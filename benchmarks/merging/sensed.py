"""Sends what the nodes of a virtual installation published through a canvas."""

from __future__ import annotations

import heapq
import json
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np

import halo_protocol as wire
from halo_client.jsonl import datagrams
from halo_service.app.recordings.node_streams import DELAY_MS
from halo_service.canvas.canvas import Canvas
from halo_service.canvas.layout import load
from halo_service.values import TouchFrame
from halo_service.virtual.clock import clocks_of
from halo_service.virtual.installation.places import AREA_MM
from halo_service.virtual.sim_url import SimRequest

START_US = 1_700_000_000_000_000
"""Arrivals are at Unix times, as live; the scenario begins at this one."""
Down = tuple[float, float, float]
"""Time in s, and place on the canvas in mm."""


def merged(
    layout: Path, streams: Sequence[Path], request: SimRequest
) -> tuple[list[TouchFrame], list[list[Down]]]:
    """Return the canvas's frames, and the downs that each node reported."""
    canvas, assembler = Canvas(load(layout)), wire.Assembler()
    nodes = [lines_of(path) for path in streams]
    sent: list[TouchFrame] = []
    for node in canvas.nodes:
        canvas.scene(node, wire.Scene(node[0], "sim", wire.VERSION, *AREA_MM, 2, 1, 2, 30.0))
        canvas.health(node, wire.Health(node[0], "sim", 30.0, DELAY_MS, 0, 0, 3, 1))
    for line in heapq.merge(*nodes, key=lambda each: each["arrived_us"]):
        arrival_us = START_US + line["arrived_us"]
        for datagram in datagrams(line):
            for event in assembler.receive_data(datagram, arrival_us / 1e6):
                if isinstance(event, wire.TouchFrame):
                    frame = canvas.arrived(event, arrival_us)
                    sent += [] if frame is None else [frame]
    return sent, _downs(streams, request)


def lines_of(path: Path) -> Iterator[dict[str, Any]]:
    """Yield the lines of a stream."""
    with path.open() as file:
        yield from map(json.loads, file)


def _downs(streams: Sequence[Path], request: SimRequest) -> list[list[Down]]:
    found: list[list[Down]] = [[] for _ in streams]
    clocks = clocks_of(request.room, request.scenario)
    for number, path in enumerate(streams, 1):
        matrix = request.room.place_of(number).canvas_from_surface
        for line in lines_of(path):
            for event in line["events"]:
                if event["kind"] == "down":
                    t_s = clocks[number].host_s(line["time_us"]) - event["ago_ms"] / 1e3
                    at = np.array([event["u"] * AREA_MM[0], event["v"] * AREA_MM[1], 0.0, 1.0])
                    x, y = (matrix @ at)[:2].tolist()
                    found[number - 1].append((t_s, x, y))
    return found
