"""What a canvas reports of itself, from what its nodes report.

Rule: pure. A client reads one scene and one health, so each field is that of the weakest node.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass

import halo_protocol as wire
from halo_service.canvas.clocks import ClockFit
from halo_service.canvas.detections import SurfaceKey
from halo_service.canvas.layout import CanvasProjector, Layout, Matrix

REVISION = 1
"""A layout does not change while the canvas runs."""


@dataclass(frozen=True, slots=True)
class NodeReports:
    """The latest reports of one node; None: not received, or the node is gone."""

    scene: wire.Scene | None = None
    health: wire.Health | None = None


@dataclass(frozen=True, slots=True)
class CanvasStatus:
    """What the canvas measures of its own state."""

    node: str
    session: str
    fps: float
    latency_ms: float
    """Median from a frame's time to its sending, as of a service: what the nodes need, and what the
    canvas adds. A canvas of this one subtracts it. -1 if unknown."""
    missed: int
    incomplete: int
    restarts: int
    """Of nodes' clocks."""
    memory_mb: int
    zenoh_missing: int
    nodes: int
    """Nodes that are there."""
    clock_offset_ms: float
    clock_deviation_ms: float
    """Of the clock that is off most; 0 and -1 without a node."""


def scene(
    status: CanvasStatus,
    layout: Layout,
    nodes: Collection[NodeReports],
    rate_hz: float,
    control_port: int,
    collision: bool,
) -> wire.Scene:
    """Return the scene of the canvas; its `rate_hz` is that of the fastest node."""
    scenes = [each.scene for each in nodes if each.scene is not None]
    complete = len(scenes) == len(nodes)
    return wire.Scene(
        status.node,
        status.session,
        wire.VERSION,
        layout.width_mm,
        layout.height_mm,
        min((each.calibration for each in scenes), default=0) if complete else min(1, len(scenes)),
        REVISION,
        max((each.source for each in scenes), default=wire.Source.CAMERA),
        max((each.rate_hz for each in scenes), default=rate_hz),
        control_port,
        int(collision),
        min((each.calibrated_s for each in scenes), default=0),
    )


def homography(status: CanvasStatus, projector: CanvasProjector, matrix: Matrix) -> wire.Homography:
    """Return where a projector's picture is on the canvas; `matrix`: the projector's."""
    return wire.Homography(
        status.node,
        status.session,
        REVISION,
        projector.width_px,
        projector.height_px,
        tuple(float(each) for each in matrix.ravel()),
    )


def health(status: CanvasStatus, nodes: Collection[NodeReports]) -> wire.Health:
    """Return the health of the canvas."""
    healths = [each.health for each in nodes if each.health is not None]
    lost = len(healths) < len(nodes)
    trackers = [each.tracker for each in healths]
    cameras = [each.camera for each in healths]
    fits = [each.profile_fit for each in healths]
    return wire.Health(
        status.node,
        status.session,
        status.fps,
        status.latency_ms,
        status.missed,
        status.incomplete,
        wire.Tracker.FAILED if wire.Tracker.FAILED in trackers else max(trackers, default=0),
        wire.Camera.LOST if lost or wire.Camera.LOST in cameras else max(cameras, default=0),
        max((each.tracker_ms for each in healths), default=-1.0),
        status.restarts,
        0.0,
        max(fits, default=0) if any(each > wire.ProfileFit.GOOD for each in fits) or lost
        else min(fits, default=0),
        status.zenoh_missing,
        sum(each.write_errors for each in healths),
        status.memory_mb,
        max((each.load for each in healths), default=0),
        min((each.looks_hz for each in healths), default=-1.0),
        nodes=status.nodes,
        clock_offset_ms=status.clock_offset_ms,
        clock_deviation_ms=status.clock_deviation_ms,
    )  # fmt: skip


def clock_sentence(surface: SurfaceKey, fit: ClockFit, behind_ms: float) -> str:
    """Say how far a node's clock is off, and how well that is measured."""
    word = "behind" if behind_ms >= 0.0 else "ahead"
    return (
        f"{'/'.join(surface)}: its clock is {abs(behind_ms):.1f} ms {word} "
        f"(+- {fit.deviation_us / 1000.0:.1f} ms, and the shortest way here is a part of it), and "
        f"drifts by {-fit.drift * 1e6:.0f} ppm (+- {max(fit.drift_deviation * 1e6, 1.0):.0f})"
    )
