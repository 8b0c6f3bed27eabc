"""The latest of what services say about themselves.

Rule: pure and bounded. What belongs to an older calibration than the scene's is let go, and so
is what a service said that has gone.
"""

from __future__ import annotations

from typing import TypeVar

from halo_protocol import Health, Homography, Lost, Pose, Report, Scene

Where = tuple[str, str]
"""(node, surface)."""

_Said = TypeVar("_Said", Scene, Homography, Pose, Health)

MAX_KNOWN = 64
"""Services' surfaces that are remembered; past it, the one that was heard longest ago goes."""


class Known:
    """Reports by (node, surface)."""

    def __init__(self) -> None:
        self.scenes: dict[Where, Scene] = {}
        self.homographies: dict[Where, Homography] = {}
        self.poses: dict[Where, Pose] = {}
        self.healths: dict[Where, Health] = {}

    def learn(self, report: Report) -> None:
        """Take in a report."""
        message = report.message
        where = (message.node, report.surface)
        if isinstance(message, Scene):
            _keep(self.scenes, where, message)
            self._outdate(where, message)
        elif isinstance(message, Homography):
            _keep(self.homographies, where, message)
        elif isinstance(message, Pose):
            _keep(self.poses, where, message)
        else:
            _keep(self.healths, where, message)

    def forget(self, lost: Lost) -> None:
        """Let go of what a session said; a newer one's reports stay."""
        where = (lost.node, lost.surface)
        for kept in (self.scenes, self.homographies, self.poses, self.healths):
            if where in kept and kept[where].session == lost.session:
                del kept[where]

    def _outdate(self, where: Where, scene: Scene) -> None:
        for kept in (self.homographies, self.poses):
            if where in kept and not _same_calibration(kept[where], scene):
                del kept[where]


def _same_calibration(placed: Homography | Pose, scene: Scene) -> bool:
    return (placed.session, placed.revision) == (scene.session, scene.revision)


def _keep(kept: dict[Where, _Said], where: Where, message: _Said) -> None:
    kept.pop(where, None)
    kept[where] = message  # Last in the order of the dict, hence last to go.
    if len(kept) > MAX_KNOWN:
        del kept[next(iter(kept))]
