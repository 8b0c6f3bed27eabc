"""`halo canvas find`: where surfaces are, by touches that two cameras see, or by a marker."""

from __future__ import annotations

import logging
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack
from itertools import combinations

import halo_protocol as wire
from halo_client import Follow, ZenohSource
from halo_service.app.canvas.nodes import follow_nodes
from halo_service.app.following import received_events
from halo_service.canvas.detections import Place, SurfaceKey
from halo_service.canvas.finding.marker import MarkerError, between
from halo_service.canvas.finding.placing import Between, placed
from halo_service.canvas.finding.rigid import RigidFit, fit
from halo_service.canvas.finding.touched import NodeTouches, pairs
from halo_service.canvas.layout import Layout
from halo_service.errors import UserError
from halo_service.host_clock import CLOCK

log = logging.getLogger(__name__)

SCENES_S = 10.0
"""Time in which every node sends its scene."""
POSES_S = 1.5
"""The same of poses, after the scenes."""
LOOK_S = 0.2
MOST_OFF_MM = 4.0
"""Pairs of touches that are farther off, root mean square, are not of one fingertip."""
MOST_ERROR_MM = 4.0
"""Likewise of the corner of the other surface that is nearest to the touches."""


class Collector:
    """What threads receive of the nodes."""

    def __init__(
        self, surfaces: Sequence[SurfaceKey], now_us: Callable[[], int] = CLOCK.unix_us
    ) -> None:
        """`now_us`: the clock by which frames arrive."""
        self._now_us = now_us
        self._lock = threading.Lock()
        self.touches = {surface: NodeTouches() for surface in surfaces}
        self.sizes_mm: dict[SurfaceKey, Place] = {}
        self.poses: dict[SurfaceKey, wire.Pose] = {}

    def handle(self, surface: SurfaceKey, events: Sequence[wire.Event]) -> None:
        """Note what arrived of one node; from any thread."""
        with self._lock:
            for event in received_events(events):
                if isinstance(event, wire.TouchFrame):
                    self.touches[surface].receive(event, self._now_us())
                elif isinstance(event, wire.Lost):
                    self.touches[surface] = NodeTouches(touches=self.touches[surface].touches)
                elif isinstance(event, wire.Report) and isinstance(event.message, wire.Scene):
                    self.sizes_mm[surface] = (event.message.width_mm, event.message.height_mm)
                elif isinstance(event, wire.Report) and isinstance(event.message, wire.Pose):
                    self.poses[surface] = event.message

    def fits(self) -> dict[tuple[SurfaceKey, SurfaceKey], tuple[int, RigidFit | None]]:
        """Return for each pair of surfaces how many touches both saw, and the fit."""
        found = {}
        with self._lock:
            for here, there in combinations(self.touches, 2):
                places = pairs(self.touches[here].touches, self.touches[there].touches)
                found[here, there] = (len(places[0]), fit(*places))
        return found


def find(
    follows: Sequence[Follow], source: ZenohSource, by: str, touches: int, seconds: float
) -> Layout:
    """Return the layout of some surfaces.

    `by`: touch or marker; `touches`: that each pair of neighbours shares; `seconds`: time for them.
    Raises `UserError`.
    """
    surfaces = [(each.node, each.surface) for each in follows]
    collector = Collector(surfaces)
    with ExitStack() as stack:
        follow_nodes(surfaces, source, collector.handle, stack)
        _wait(lambda: len(collector.sizes_mm) == len(surfaces), SCENES_S)
        if missing := [_name(each) for each in surfaces if each not in collector.sizes_mm]:
            raise UserError(
                f"canvas: no service sends {' or '.join(missing)} at "
                f"{', '.join(source.connect) or source.config}; 'halo list' shows what is there"
            )
        if by == "marker":
            _wait(lambda: len(collector.poses) == len(surfaces), POSES_S)
            known = list(_by_marker(collector))
        else:
            known = by_touch(collector, touches, seconds)
        sizes_mm = {surface: collector.sizes_mm[surface] for surface in surfaces}
    layout, away = placed(sizes_mm, known)
    if away:
        names = ", ".join(map(_name, away))
        raise UserError(
            f"canvas: {names} cannot be placed: {REMEDIES[by]}, or write the layout by hand"
        )
    return layout


REMEDIES = {
    "touch": "touch where its camera and a placed one both see the finger",
    "marker": "put the marker where its camera and a placed one see it, and run 'halo calibrate "
    "anchor' for both",
}


def _by_marker(collector: Collector) -> Iterator[Between]:
    anchored = {surface: pose for surface, pose in collector.poses.items() if pose.anchored}
    for here, there in combinations(anchored, 2):
        try:
            matrix = between(anchored[here], anchored[there])
        except MarkerError as error:
            log.warning("%s and %s do not see one marker: %s", _name(here), _name(there), error)
            continue
        log.info("%s is placed on %s by the marker", _name(there), _name(here))
        yield Between(here, there, matrix, 1.0)


def by_touch(collector: Collector, touches: int, seconds: float) -> list[Between]:
    """Wait for touches; return what fits well. Raises `UserError` for what does not."""
    log.info(
        "touch the table where two cameras see it: one finger, half a second each, at %d places "
        "that are far apart",
        touches,
    )
    counts: dict[tuple[SurfaceKey, SurfaceKey], int] = {}
    until_s = time.monotonic() + seconds
    while time.monotonic() < until_s:
        time.sleep(LOOK_S)
        fits = collector.fits()
        for pair, (count, _) in fits.items():
            if count > counts.get(pair, 0):
                counts[pair] = count
                log.info("touch %d of %d: %s and %s", count, touches, *map(_name, pair))
        enough = {pair for pair, count in counts.items() if count >= touches}
        if len(_reached(list(collector.touches), enough)) == len(collector.touches):
            break
    found = collector.fits()
    known = [_checked(collector, pair, *found[pair]) for pair in found if found[pair][0] >= touches]
    if not known:
        most = max((count for count, _ in found.values()), default=0)
        raise UserError(
            f"canvas: {most} of {touches} touches were seen by two cameras within {seconds:.0f} s; "
            "touch where both see the finger, or give more time with --seconds"
        )
    return known


def _checked(
    collector: Collector, pair: tuple[SurfaceKey, SurfaceKey], count: int, found: RigidFit | None
) -> Between:
    """Return a fit that is good, and say how good. Raises `UserError`."""
    here, there = pair
    names = f"{_name(here)} and {_name(there)}"
    if found is None:
        raise UserError(
            f"canvas: the {count} touches of {names} do not fit together; touch with one finger at "
            "a time, hold it still for half a second, and try again"
        )
    width_mm, height_mm = collector.sizes_mm[there]
    corners = [(x, y) for x in (0.0, width_mm) for y in (0.0, height_mm)]
    near = min(found.error_mm(each) for each in corners)
    far = max(found.error_mm(each) for each in corners)
    if found.off_mm > MOST_OFF_MM:
        raise UserError(
            f"canvas: the touches of {names} are off by {found.off_mm:.1f} mm, more than "
            f"{MOST_OFF_MM:g}; hold the finger still for half a second, or calibrate the cameras "
            "again"
        )
    if near > MOST_ERROR_MM:
        raise UserError(
            f"canvas: the touches of {names} leave an error of {near:.1f} mm at the seam; touch "
            "places that are farther apart, or more of them with --touches"
        )
    log.info(
        "%s on %s: x %.1f mm, y %.1f mm, %.2f degrees, by %d of %d touches that are off by "
        "%.1f mm; expected error %.1f mm at the seam, %.1f mm at the far corner",
        _name(there), _name(here), *found.matrix[:2, 2], found.angle_deg, found.count, count,
        found.off_mm, near, far,
    )  # fmt: skip
    return Between(here, there, found.matrix, near)


def _reached(
    surfaces: Sequence[SurfaceKey], linked: set[tuple[SurfaceKey, SurfaceKey]]
) -> set[SurfaceKey]:
    """Return the surfaces that are linked with the first one."""
    reached = {surfaces[0]}
    while more := {w for pair in linked if reached & set(pair) for w in pair} - reached:
        reached |= more
    return reached


def _wait(condition: Callable[[], bool], seconds: float) -> None:
    until_s = time.monotonic() + seconds
    while not condition() and time.monotonic() < until_s:
        time.sleep(LOOK_S / 4.0)


def _name(surface: SurfaceKey) -> str:
    return "/".join(surface)
