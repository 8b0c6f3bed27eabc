"""A recorded stream as a picture, PNG or SVG.

Rule: no window, no clock; the picture shows the end of the stream.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from pathlib import Path

import pygame

from halo_client import PictureTransform
from halo_client.files import appearing
from halo_paint.brushes import PAPER
from halo_paint.canvas import Canvas, Pixels
from halo_paint.painter import Painter
from halo_paint.stroke import Stroke
from halo_paint.svg import to_svg
from halo_protocol import TouchFrame

WIDTH_PX = 1920
KINDS = (".png", ".svg")


def painted(frames: Iterable[TouchFrame], painter: Painter) -> list[Stroke]:
    """Return all strokes of a stream."""
    for frame in frames:
        painter.process(frame)
    return painter.strokes


def to_pixels(
    strokes: Sequence[Stroke], width_mm: float, height_mm: float, width_px: int = WIDTH_PX
) -> Pixels:
    """Return the surface as a picture `width_px` wide."""
    height_px = round(width_px * height_mm / width_mm)
    canvas = Canvas(
        width_px, height_px, PictureTransform.fitted(width_px, height_px, width_mm, height_mm)
    )
    canvas.repaint(list(strokes))
    return canvas.pixels


def save(path: Path, strokes: Sequence[Stroke], width_mm: float, height_mm: float) -> None:
    """Write a PNG or SVG, by the file's suffix. Raises `OSError`, `ValueError`."""
    if path.suffix.lower() == ".svg":
        with appearing(path) as file:
            file.write(to_svg(strokes, width_mm, height_mm, PAPER).encode())
    elif path.suffix.lower() == ".png":
        write_png(path, to_pixels(strokes, width_mm, height_mm))
    else:
        raise ValueError(f"{path} is neither {' nor '.join(KINDS)}")


def write_png(path: Path, pixels: Pixels) -> None:
    """Write (H, W, 3) pixels as PNG. Raises `OSError`."""
    picture = pygame.image.frombuffer(pixels.tobytes(), pixels.shape[1::-1], "RGB")
    with appearing(path) as file:
        pygame.image.save(picture, file, "x.png")
