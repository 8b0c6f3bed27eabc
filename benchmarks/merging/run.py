"""Sends the streams of simulated nodes through a canvas, in the order of their arrival."""

from __future__ import annotations

import heapq
import time
from collections.abc import Iterator, Sequence

import numpy as np

import halo_protocol as wire
from halo_service.canvas.canvas import Canvas
from halo_service.canvas.layout import Layout, PlacedSurface
from halo_service.values import TouchFrame

from .nodes import Arrival, Errors, SimulatedNode
from .score import Score, score
from .truth import Truth, crossings

WIDTH_MM, HEIGHT_MM, OVERLAP_MM = 300.0, 200.0, 40.0
START_US = 1_700_000_000_000_000
TICK_S = 0.1


def table(nodes: int) -> tuple[Layout, list[tuple[float, float, float, float]], list[float]]:
    """Return a layout of surfaces in a row, their rectangles, and where their seams are."""
    step_mm = WIDTH_MM - OVERLAP_MM
    rectangles = [(i * step_mm, 0.0, WIDTH_MM, HEIGHT_MM) for i in range(nodes)]
    surfaces = tuple(PlacedSurface(f"node{i}", x_mm=each[0]) for i, each in enumerate(rectangles))
    seams = [i * step_mm + OVERLAP_MM / 2.0 for i in range(1, nodes)]
    return Layout(step_mm * (nodes - 1) + WIDTH_MM, HEIGHT_MM, surfaces), rectangles, seams


def simulated(nodes: int, count: int, seed: int, errors: Errors | None = None) -> Score:
    """Cross the seams of a row of nodes; return how well the canvas merged it."""
    layout, rectangles, seams = table(nodes)
    truth = crossings(count, seams, HEIGHT_MM, seed)
    simulated_nodes = [
        SimulatedNode(
            f"node{i}",
            each,
            np.random.default_rng((seed, i)),
            errors or Errors(),
        )
        for i, each in enumerate(rectangles)
    ]
    for node in simulated_nodes:
        node.peers = [each for each in simulated_nodes if each is not node]
    canvas = Canvas(layout)
    frames, late_ms = run(canvas, simulated_nodes, truth)
    result = score(truth, frames, START_US, seams)
    result.late_ms = late_ms
    return result


def run(
    canvas: Canvas, nodes: Sequence[SimulatedNode], truth: Truth
) -> tuple[list[TouchFrame], list[float]]:
    """Return the canvas's frames, and the ms after which each node's frame with pointers left.

    The time that the computation itself takes is a part of these.
    """
    assembler = wire.Assembler()
    for node in nodes:
        canvas.scene((node.name, "table"), node.scene)
        canvas.health((node.name, "table"), node.health)
    sent: list[TouchFrame] = []
    late_ms: list[float] = []
    waiting_s: list[float] = []
    for arrival in in_order(nodes, truth):
        began_s = time.perf_counter()
        events = assembler.receive_data(arrival.datagram, arrival.arrival_s)
        for event in events:
            if not isinstance(event, wire.TouchFrame):
                continue
            if event.pointers or event.events:
                waiting_s.append(arrival.arrival_s)
            frame = canvas.arrived(event, START_US + round(arrival.arrival_s * 1e6))
            if frame is not None:
                spent_s = time.perf_counter() - began_s
                late_ms += [(arrival.arrival_s - each + spent_s) * 1e3 for each in waiting_s]
                waiting_s.clear()
                sent.append(frame)
    return sent, late_ms


def in_order(nodes: Sequence[SimulatedNode], truth: Truth) -> Iterator[Arrival]:
    """Yield the datagrams of all nodes in the order of their arrival."""
    return heapq.merge(*(each.stream(truth) for each in nodes), key=lambda each: each.arrival_s)
