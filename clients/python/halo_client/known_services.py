"""The latest reports of each service: scene, homography, pose, health.

Rule: pure and bounded. Reports of an older calibration than the scene's are removed, and so
are reports of a lost service.
"""

from __future__ import annotations

from typing import TypeVar

from halo_client.follow import Key
from halo_protocol import Health, Homography, Lost, Pose, Report, Scene

Where = tuple[str, str]
"""(node, surface)."""

_Message = TypeVar("_Message", Scene, Homography, Pose, Health)

MAX_KNOWN = 64
"""Surfaces that are remembered; beyond, the one with the oldest report is removed."""


class KnownServices:
    """Reports by (node, surface)."""

    def __init__(self) -> None:
        self.scenes: dict[Where, Scene] = {}
        self.homographies: dict[Where, Homography] = {}
        self.poses: dict[Where, Pose] = {}
        self.healths: dict[Where, Health] = {}

    def update(self, report: Report) -> None:
        """Store a report."""
        message = report.message
        where = (message.node, report.surface)
        if isinstance(message, Scene):
            _store(self.scenes, where, message)
            self._remove_outdated(where, message)
        elif isinstance(message, Homography):
            _store(self.homographies, where, message)
        elif isinstance(message, Pose):
            _store(self.poses, where, message)
        else:
            _store(self.healths, where, message)

    def forget(self, lost: Lost) -> None:
        """Remove the reports of a lost session; those of a newer one stay."""
        where = (lost.node, lost.surface)
        for reports in (self.scenes, self.homographies, self.poses, self.healths):
            if where in reports and reports[where].session == lost.session:
                del reports[where]

    def placing(self, following: Key | None) -> tuple[Scene | None, Homography | None]:
        """Return scene and homography of one service, so that another one moves no picture.

        `following`: its node, surface and session; None: the service with the newest scene.
        """
        newest = next(reversed(list(self.scenes)), ("", ""))
        where = newest if following is None else following[:2]
        return self.scenes.get(where), self.homographies.get(where)

    def _remove_outdated(self, where: Where, scene: Scene) -> None:
        for reports in (self.homographies, self.poses):
            if where in reports and not _same_calibration(reports[where], scene):
                del reports[where]


def _same_calibration(placed: Homography | Pose, scene: Scene) -> bool:
    return (placed.session, placed.revision) == (scene.session, scene.revision)


def _store(reports: dict[Where, _Message], where: Where, message: _Message) -> None:
    reports.pop(where, None)
    reports[where] = message  # Moved to the end of the dict: last to be removed.
    if len(reports) > MAX_KNOWN:
        del reports[next(iter(reports))]
