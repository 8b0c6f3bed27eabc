"""Draw the pipeline and the coordinate frames as SVG.

    uv run python docs/drawings.py

Writes docs/pictures/pipeline.svg and docs/pictures/frames.svg. The same code gives the same bytes;
a test compares them.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Sequence
from pathlib import Path
from xml.sax.saxutils import escape

FOLDER = Path(__file__).parent / "pictures"
INK, GREY, LIGHT = "#1c2430", "#6a7480", "#eef1f5"
RED, GREEN, BLUE = "#c62f2f", "#2c8a3d", "#2457c5"
"""x, y and z, as most 3D programs draw them."""
THREAD = "#d9822b"
"""What runs in parallel with the frames."""
Point = tuple[float, float]
Place = tuple[float, float, float]


class Svg:
    """Lines of an SVG file."""

    def __init__(self, width: int, height: int) -> None:
        self._lines = [
            f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" '
            f'width="{width}" height="{height}" font-family="sans-serif" font-size="14">',
            f'<rect width="{width}" height="{height}" fill="white"/>',
        ]

    def text(
        self,
        at: Point,
        words: str,
        colour: str = INK,
        size: int = 14,
        anchor: str = "middle",
        weight: str = "normal",
    ) -> None:
        """One line of words; `at` is its base line."""
        self._lines.append(
            f'<text x="{at[0]:.1f}" y="{at[1]:.1f}" fill="{colour}" font-size="{size}" '
            f'text-anchor="{anchor}" font-weight="{weight}">{escape(words)}</text>'
        )

    def polygon(self, points: Sequence[Point], fill: str, stroke: str = INK) -> None:
        """A closed outline."""
        corners = " ".join(f"{x:.1f},{y:.1f}" for x, y in points)
        self._lines.append(
            f'<polygon points="{corners}" fill="{fill}" stroke="{stroke}" stroke-width="1.5"/>'
        )

    def line(self, begin: Point, end: Point, colour: str = INK, dash: str = "none") -> None:
        """A straight line."""
        self._lines.append(
            f'<line x1="{begin[0]:.1f}" y1="{begin[1]:.1f}" x2="{end[0]:.1f}" y2="{end[1]:.1f}" '
            f'stroke="{colour}" stroke-width="2" stroke-dasharray="{dash}"/>'
        )

    def arrow(self, begin: Point, end: Point, colour: str = INK, dash: str = "none") -> None:
        """A line with a head at its end."""
        angle = math.atan2(end[1] - begin[1], end[0] - begin[0])
        back = [
            (end[0] - 11 * math.cos(angle + turn), end[1] - 11 * math.sin(angle + turn))
            for turn in (0.4, -0.4)
        ]
        neck = ((back[0][0] + back[1][0]) / 2, (back[0][1] + back[1][1]) / 2)
        self.line(begin, neck, colour, dash)
        self.polygon([end, *back], colour, colour)

    def box(
        self, left: float, top: float, lines: Sequence[str], fill: str, wide: int = 150
    ) -> None:
        """A box 62 high: a name, and below it smaller words."""
        self.polygon(
            [(left, top), (left + wide, top), (left + wide, top + 62), (left, top + 62)], fill
        )
        for row, words in enumerate(lines):
            y = top + 36 - 8.5 * (len(lines) - 1) + 17 * row
            size, weight = (14, "bold") if row == 0 else (11, "normal")
            self.text((left + wide / 2, y), words, size=size, weight=weight)

    def write(self, path: Path) -> None:
        """Write the file."""
        path.write_text("\n".join([*self._lines, "</svg>", ""]), encoding="utf-8")
        sys.stdout.write(f"{path}\n")


STAGES = (
    ("associate", "detections to tracks"),
    ("segment", "surface, hand, halo"),
    ("measure", "halo at each fingertip"),
    ("correct", "for place and angle"),
    ("contacts", "touch, hover, pressure"),
)


def pipeline(path: Path) -> None:
    """From a camera to clients; the hand tracker runs in parallel, the profile comes first."""
    svg = Svg(1080, 500)
    sources = ("source", "camera, recording", "or virtual camera")
    svg.box(30, 180, sources, LIGHT)
    svg.polygon([(235, 130), (1050, 130), (1050, 275), (235, 275)], "#f7f9fc", GREY)
    svg.text((250, 153), "sensing/step.py: step(state, frame, hands) -> (TouchFrame, state)",
             anchor="start", weight="bold")  # fmt: skip
    svg.text((500, 263), "pure: no clock, no input or output; a replay gives the same bytes", GREY,
             12, anchor="start")  # fmt: skip
    for column, stage in enumerate(STAGES):
        left = 250 + 160 * column
        svg.box(left, 172, stage, "white", wide=145)
        if column:
            svg.arrow((left - 15, 203), (left, 203))
    svg.arrow((180, 203), (250, 203))
    svg.text((208, 195), "Frame", size=12)

    svg.box(
        250, 340, ("hand tracker", "MediaPipe, its own thread", "hand_tracking/"), "#fdf1e4", 190
    )
    svg.arrow((105, 242), (250, 371), THREAD)
    svg.text((90, 320), "newest Frame", THREAD, 12)
    svg.arrow((322, 340), (322, 234), THREAD)
    svg.text((332, 320), "21 landmarks per hand, one frame or more old", THREAD, 12, "start")

    svg.line((105, 180), (105, 61))
    svg.arrow((105, 61), (250, 61))
    svg.text((178, 53), "Frames", size=12)
    svg.box(250, 30, ("calibration", "guided steps, once", "calibration/"), LIGHT, 190)
    svg.box(520, 30, ("profile", "background, plane, states", "profile/"), LIGHT, 190)
    svg.arrow((440, 61), (520, 61))
    svg.arrow((615, 92), (615, 130))

    svg.box(
        810, 340, ("outputs", "OSC bundles, TUIO, JSON", "outputs/, web/, protocol/"), LIGHT, 190
    )
    svg.arrow((962, 234), (962, 340))
    svg.text((952, 320), "TouchFrame", size=12, anchor="end")
    svg.box(550, 430, ("clients", "clients/"), LIGHT, 190)
    svg.line((905, 402), (905, 461))
    svg.arrow((905, 461), (740, 461))
    svg.text((825, 452), "UDP, Zenoh, WebSocket", size=12)
    svg.text((30, 488), "Orange: runs in parallel; no frame waits for it.", THREAD, 12, "start")
    svg.write(path)


def seen(place: Place) -> Point:
    """Where a place over the table is in the drawing, px; mm as in the surface frame."""
    x, y, z = place
    return 300 + x - 0.55 * y, 420 + 0.6 * y + 0.85 * z


def axes(
    svg: Svg, origin: Place, turn_deg: float, names: Sequence[str], length: float = 70
) -> None:
    """Three arrows (two for pixels): x, y turned about z on the table, z down."""
    cos, sin = math.cos(math.radians(turn_deg)), math.sin(math.radians(turn_deg))
    ways = ((cos, sin, 0.0), (-sin, cos, 0.0), (0.0, 0.0, 1.0))
    for way, name, colour in zip(ways, names, (RED, GREEN, BLUE), strict=False):
        end = tuple(o + length * w for o, w in zip(origin, way, strict=True))
        beyond = tuple(o + (length + 14) * w for o, w in zip(origin, way, strict=True))
        svg.arrow(seen(origin), seen((end[0], end[1], end[2])), colour)
        at = seen((beyond[0], beyond[1], beyond[2]))
        right, below = {"x": (0, -3), "y": (-8, 3)}.get(name, (0, 5))  # next to the edges
        svg.text((at[0] + right, at[1] + below), name, colour, weight="bold")


def flat(svg: Svg, corner: Place, size: Point, turn_deg: float, fill: str) -> None:
    """A rectangle that lies level: a table, a sheet, a picture."""
    cos, sin = math.cos(math.radians(turn_deg)), math.sin(math.radians(turn_deg))
    corners = ((0.0, 0.0), (size[0], 0.0), size, (0.0, size[1]))
    svg.polygon(
        [
            seen((corner[0] + cos * x - sin * y, corner[1] + sin * x + cos * y, corner[2]))
            for x, y in corners
        ],
        fill,
    )


FRAMES = {
    "surface": (
        "origin: far left corner, as the user sits",
        "x right, y to the user, z into the surface",
        "mm; height above the surface = -z; u = x / width, v = y / height",
    ),
    "camera": (
        "origin: the depth camera's lens",
        "x right, y down in the image, z away from the lens",
        "mm",
    ),
    "projector": ("origin: outer corner of the top left pixel", "x right, y down", "pixels"),
    "anchor": (
        "origin: middle of the printed marker",
        "x to its right, y to its lower edge, z into it",
        "mm",
    ),
}
MATRICES = (
    "p_camera = camera_from_surface · p_surface   (4x4, mm)",
    "p_anchor = anchor_from_surface · p_surface   (4x4, mm)",
    "(a, b, c) = projector_from_surface · (x, y, 1)   (3x3, mm to pixels)",
    "pixel = (a / c, b / c)",
)


def frames(path: Path) -> None:
    """Camera, surface, projector and anchor: axes, units, and the matrices between them."""
    svg = Svg(1290, 600)
    camera, picture, anchor = (150.0, 100.0, -420.0), (-80.0, -60.0, 0.0), (390.0, 102.0, 0.0)
    flat(svg, (-130, -90, 0), (580, 380), 0, "#f3ede3")
    flat(svg, picture, (425, 305), 0, "#fff6cc")
    flat(svg, (0, 0, 0), (300, 200), 0, "#ffffff")
    flat(svg, (375, 70, 0), (50, 50), 20, "#d5d9e0")
    for corner in ((300.0, 0.0, 0.0), (0.0, 200.0, 0.0)):
        svg.line(seen(camera), seen(corner), "#c9ced6", "4 5")
    for end, words, at in (
        (camera, "camera_from_surface", (424, 290)),
        (picture, "projector_from_surface", (190, 356)),
        (anchor, "anchor_from_surface", (467, 484)),
    ):
        svg.arrow(seen((0, 0, 0)), seen(end), GREY, "6 4")
        svg.text(at, words, size=13)
    axes(svg, (0, 0, 0), 0, ("x", "y", "z"))
    axes(svg, camera, 0, ("x", "y", "z"))
    axes(svg, picture, 0, ("x", "y"), 75)
    axes(svg, anchor, 20, ("x", "y", "z"), 38)
    for at, words in (
        ((345, 522), "surface"),
        ((395, 107), "camera"),
        ((327, 559), "projector's picture"),
        ((648, 450), "anchor"),
    ):
        svg.text(at, words, weight="bold", size=15)
    svg.text((290, 586), "user", GREY, weight="bold")
    y = 60.0
    for name, lines in FRAMES.items():
        svg.text((840, y), name, size=16, anchor="start", weight="bold")
        for words in lines:
            y += 19
            svg.text((840, y), words, size=13, anchor="start")
        y += 34
    for words in MATRICES:
        svg.text((840, y), words, size=13, anchor="start")
        y += 22
    svg.write(path)


def main(folder: Path = FOLDER) -> None:
    """Draw both."""
    folder.mkdir(parents=True, exist_ok=True)
    pipeline(folder / "pipeline.svg")
    frames(folder / "frames.svg")


if __name__ == "__main__":
    main()
