"""Follows the nodes of a canvas: a thread for each."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from contextlib import ExitStack
from functools import partial

import halo_protocol as wire
from halo_client import Follow, ZenohSource
from halo_service.app.following import Following, opened
from halo_service.canvas.detections import SurfaceKey


def follow_nodes(
    nodes: Iterable[SurfaceKey],
    source: ZenohSource,
    handle: Callable[[SurfaceKey, list[wire.Event]], None],
    stack: ExitStack,
) -> None:
    """Call `handle` with what arrives of each node, in its thread, until `stack` ends them.

    Raises `UserError`.
    """
    for surface in nodes:
        follow = Follow(*surface)
        following = Following(
            opened(source, follow, "canvas"), follow, partial(handle, surface), "canvas"
        )
        following.start()
        stack.callback(following.close)
