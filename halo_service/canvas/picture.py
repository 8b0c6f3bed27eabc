"""Draws a canvas: the nodes' surfaces, what each node reported, and the merged pointers.

Thin lines are the nodes', each in its own grey; thick lines are the canvas's, a colour for each
pointer; a ring is a touch that began. A pointer that keeps its id keeps its colour over a seam.
"""

from __future__ import annotations

import colorsys
from collections import defaultdict, deque
from itertools import pairwise

import cv2
import numpy as np
from numpy.typing import NDArray

import halo_protocol as wire
from halo_service.canvas.detections import Area, Place, SurfaceKey, mapped
from halo_service.canvas.layout import Layout
from halo_service.values import Touch, TouchFrame

MARGIN_MM = 20.0
LONGEST_PX = 1600
MOST = 20_000
"""Places of one line that are remembered."""
PAPER, FRAME = (255, 255, 255), (170, 170, 170)
GREYS = ((150, 120, 90), (90, 130, 160), (120, 160, 110), (140, 110, 160))


class Picture:
    """Collects places and draws them; colours are blue, green, red."""

    def __init__(self, layout: Layout) -> None:
        self._layout = layout
        longest_mm = max(layout.width_mm, layout.height_mm) + 2.0 * MARGIN_MM
        self._px_per_mm = LONGEST_PX / longest_mm
        self._areas: dict[SurfaceKey, Area] = {}
        self._node_lines: dict[tuple[SurfaceKey, str, int], deque[Place]] = defaultdict(
            lambda: deque(maxlen=MOST)
        )
        self._lines: dict[int, deque[tuple[Place, bool]]] = defaultdict(lambda: deque(maxlen=MOST))
        self._downs: deque[tuple[int, Place]] = deque(maxlen=MOST)

    def add_node(self, area: Area, frame: wire.TouchFrame) -> None:
        """Note the pointers of a node."""
        self._areas[area.surface] = area
        for pointer in frame.pointers:
            line = self._node_lines[area.surface, frame.session, pointer.id]
            line.append(mapped(area.canvas_from_surface, (pointer.x_mm, pointer.y_mm)))

    def add(self, frame: TouchFrame) -> None:
        """Note the pointers and downs of the canvas."""
        for pointer in frame.pointers:
            touching = pointer.state is Touch.TOUCH
            self._lines[pointer.id].append(((pointer.x_mm, pointer.y_mm), touching))
        for event in frame.events:
            if event.kind == "down":
                self._downs.append((event.id, (event.x_mm, event.y_mm)))

    def drawn(self) -> NDArray[np.uint8]:
        """Return the picture, (H, W, 3) uint8."""
        layout = self._layout
        width, height = self._px((layout.width_mm + MARGIN_MM, layout.height_mm + MARGIN_MM))
        image = np.full((height, width, 3), PAPER, np.uint8)
        corners = self._px((0.0, 0.0)), self._px((layout.width_mm, layout.height_mm))
        cv2.rectangle(image, *corners, FRAME, 3)
        for number, area in enumerate(self._areas.values()):
            self._draw_area(image, area, GREYS[number % len(GREYS)])
        names = list(self._areas)
        for (surface, _, _), line in self._node_lines.items():
            self._draw(image, list(line), GREYS[names.index(surface) % len(GREYS)], 1)
        for id_, places in self._lines.items():
            self._draw(image, [place for place, _ in places], colour(id_), 2)
            touched = [place for place, touching in places if touching]
            for place in touched:
                cv2.circle(image, self._px(place), 4, colour(id_), -1, cv2.LINE_AA)
        for id_, place in self._downs:
            cv2.circle(image, self._px(place), 9, colour(id_), 2, cv2.LINE_AA)
        return image

    def _draw_area(self, image: NDArray[np.uint8], area: Area, grey: tuple[int, int, int]) -> None:
        corners = np.array([self._px(each) for each in area.corners_mm()], np.int32)
        if not len(corners):
            return
        cv2.polylines(image, [corners], True, grey, 1, cv2.LINE_AA)
        x, y = corners.min(axis=0)
        at = (int(x) + 8, int(y) + 22)
        name = "/".join(area.surface)
        cv2.putText(image, name, at, cv2.FONT_HERSHEY_SIMPLEX, 0.6, grey, 1, cv2.LINE_AA)

    def _draw(
        self, image: NDArray[np.uint8], line: list[Place], colour: tuple[int, int, int], px: int
    ) -> None:
        for before, after in pairwise(line):
            cv2.line(image, self._px(before), self._px(after), colour, px, cv2.LINE_AA)

    def _px(self, place_mm: Place) -> tuple[int, int]:
        x, y = place_mm
        return round((x + MARGIN_MM) * self._px_per_mm), round((y + MARGIN_MM) * self._px_per_mm)


def colour(id_: int) -> tuple[int, int, int]:
    """Return the colour of a pointer; neighbours in number differ most."""
    red, green, blue = colorsys.hsv_to_rgb(id_ * 0.382 % 1.0, 0.85, 0.8)
    return round(255 * blue), round(255 * green), round(255 * red)
