"""`halo-paint`: paint with a finger; the harder it presses, the stronger the stroke.

Rule: input and output only. It opens the window, passes frames to the pure part, and saves.
"""

from __future__ import annotations

import argparse
import logging
import sys
import time
from collections.abc import Sequence
from contextlib import ExitStack
from pathlib import Path

import pygame

import halo_client
from halo_client import ClientError, FileSource, Receiver
from halo_client.files import appearing
from halo_client.picture import HEIGHT_MM, WIDTH_MM
from halo_paint.animated import to_svg
from halo_paint.brushes import BRUSHES
from halo_paint.painter import Change, Painter
from halo_paint.render import KINDS, painted, save
from halo_paint.view import View
from halo_protocol import Pointer, TouchFrame
from halo_window import Stage, StageError, add_stage_options, listen

NAME = "halo-paint"
DESCRIPTION = "Paint on any table: the harder you press, the wider and denser the stroke."
EPILOG = """\
how to paint:
  touch and draw     light for a fine line, hard for a broad one
  left edge          colours
  right edge         brush, pen, calligraphy; undo, clear, save
  keys               u undo, c clear, s save (as PNG and SVG), q or Escape ends

examples:
  halo-paint                                     use the touches of `halo serve`
  halo-paint --full-screen --display 1           on the projector, paint under your finger
  halo-paint --from x.jsonl --render x.svg       a recorded stream as a picture (.png or .svg)
"""


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command; return 0, or 2 if it cannot start."""
    options = _parser().parse_args(argv)
    logging.basicConfig(format=f"{NAME}: %(message)s", level=logging.WARNING)
    brush = next(each for each in BRUSHES if each.name == options.brush)
    painter = Painter(brush=brush, vary=options.vary)
    try:
        if options.render or options.animate:
            return _render(options, painter)
        with ExitStack() as stack:
            receiver = stack.enter_context(halo_client.connect(options.source))
            stage = stack.enter_context(Stage(NAME, options.full_screen, options.display))
            App(receiver, stage, painter, options.save_to).run()
        return 0
    except (ClientError, StageError, OSError) as error:
        print(f"{NAME}: {error}", file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        return 0


class App:
    """The window and its painting."""

    def __init__(self, receiver: Receiver, stage: Stage, painter: Painter, folder: Path) -> None:
        self._receiver, self._stage, self._painter = receiver, stage, painter
        self._folder = folder
        self._fingers: tuple[Pointer, ...] = ()
        self._view = View(
            stage.screen.get_size(), stage.placed(receiver.services, receiver.following)
        )
        self._note, self._note_s = "", 0.0

    def run(self) -> None:
        """Run until the window is closed."""
        listen(NAME, self._receiver, self._stage, self._process, self._draw)

    def _process(self, frame: TouchFrame, now_s: float) -> None:
        self._fingers = frame.pointers
        news = self._painter.process(frame)
        self._view.update(news, self._painter)
        if any(change is Change.SAVE for change, _ in news):
            self._save(now_s)

    def _draw(self, now_s: float, note: str) -> None:
        for key in self._stage.pressed():
            self._key(key, now_s)
        self._fit()
        recent = self._note if now_s - self._note_s < 4.0 else ""
        self._view.draw(self._stage.screen, self._painter, self._fingers, note or recent)
        self._stage.show(self._view.parts)

    def _key(self, key: int, now_s: float) -> None:
        if key == pygame.K_u:
            self._view.update(self._painter.undo(), self._painter)
        elif key == pygame.K_c:
            self._view.update(self._painter.clear(), self._painter)
        elif key == pygame.K_s:
            self._save(now_s)

    def _fit(self) -> None:
        """Redraw everything if the window or the homography has changed."""
        size = self._stage.screen.get_size()
        placed = self._stage.placed(self._receiver.services, self._receiver.following)
        if (size, placed) != (self._view.size, self._view.placed):
            self._painter.size_mm = (placed.width_mm, placed.height_mm)
            self._view = View(size, placed)
            self._view.update([(Change.UNDONE, None)], self._painter)

    def _save(self, now_s: float) -> None:
        name = time.strftime("painting-%Y%m%d-%H%M%S")
        try:
            self._folder.mkdir(parents=True, exist_ok=True)
            for kind in KINDS:
                save(self._folder / (name + kind), self._painter.strokes, *self._painter.size_mm)
        except OSError as error:
            self._note = f"could not save ({error})"
        else:
            self._note = f"saved {self._folder / name}.png and .svg"
        self._note_s = now_s
        print(f"{NAME}: {self._note}", file=sys.stderr)


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog=NAME,
        description=DESCRIPTION,
        epilog=EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    add_stage_options(parser)
    parser.add_argument(
        "--brush",
        choices=[brush.name for brush in BRUSHES],
        default=BRUSHES[0].name,
        help="first brush (%(default)s)",
    )
    parser.add_argument(
        "--vary", action="store_true", help="change colour and brush with each stroke"
    )
    parser.add_argument(
        "--save-to",
        type=Path,
        default=Path(),
        metavar="FOLDER",
        help="folder for saved pictures (default: this one)",
    )
    parser.add_argument(
        "--render",
        type=Path,
        action="append",
        default=[],
        metavar="OUT",
        help="write the picture of --from FILE.jsonl, .png or .svg; may be repeated",
    )
    parser.add_argument(
        "--animate",
        type=Path,
        metavar="OUT.svg",
        help="write --from FILE.jsonl as a picture that paints itself, for a web page",
    )
    return parser


def _render(options: argparse.Namespace, painter: Painter) -> int:
    source = halo_client.parse_source(options.source)
    if not isinstance(source, FileSource):
        option = "--render" if options.render else "--animate"
        raise ClientError(f"{option} needs a recorded stream: --from FILE.jsonl")
    for path in options.render:
        if path.suffix.lower() not in KINDS:
            raise ClientError(f"{path} is neither a {' nor a '.join(KINDS)}")
    frames = halo_client.frames(FileSource(source.path, paced=False))
    if options.animate:
        with appearing(options.animate) as file:
            file.write(to_svg(list(frames), painter, WIDTH_MM, HEIGHT_MM).encode())
        print(f"{NAME}: wrote {options.animate}")
        strokes = painter.strokes
    else:
        strokes = painted(frames, painter)
    for path in options.render:
        save(path, strokes, WIDTH_MM, HEIGHT_MM)
        print(f"{NAME}: wrote {path}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
