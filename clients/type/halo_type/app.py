"""`halo-type`: a keyboard on any table, with phrases to type and results as in a study.

Rule: input and output only. It opens window and sound, passes frames to the pure part, and writes
the results.
"""

from __future__ import annotations

import argparse
import logging
import sys
import time
from collections import deque
from collections.abc import Sequence
from contextlib import ExitStack
from pathlib import Path

import miniaudio
import numpy as np

import halo_client
from halo_client import ClientError, FileSource, Receiver
from halo_client.files import appearing
from halo_drums.errors import SoundError
from halo_drums.mixer import Mixer
from halo_drums.speakers import Speakers
from halo_protocol import Pointer, TouchFrame
from halo_type.animated import to_svg
from halo_type.layout import LAYOUTS, Layout, LayoutError, load_layout
from halo_type.phrases import PHRASES, PhrasesError, in_order_of_seed, read_phrases
from halo_type.results import summary, write_results
from halo_type.sounds import key_sounds, sound_of
from halo_type.typist import Struck, Trial, Typist
from halo_type.view import View
from halo_window import Stage, StageError, add_stage_options, listen

NAME = "halo-type"
DESCRIPTION = "Type on any table: a keyboard under your fingers, phrases, and how well it went."
EPILOG = """\
how to type:
  touch a key        it counts when your finger comes down
  delete, done       erase the last letter; go to the next phrase
  q or Escape        (on the real keyboard) ends

results: one CSV file, a row for each phrase and one for each task: words a minute, accuracy,
their product (AWPM), errors left in the text and errors that you corrected

examples:
  halo-type                                      use the touches of `halo serve`
  halo-type --full-screen --display 1            on the projector, keys under your fingers
  halo-type --tasks accurate,balanced,fast --participant P7 --results p7.csv
  halo-type --phrases mine.txt --layout azerty   your own phrases and keys
  halo-type --from x.jsonl --seed 3 --render x.csv    the results of a recorded stream
"""
FREE_TASK = "free"
NO_SOUND = "plug one in, or use --silent"
MOST_WAITING = 256
"""Keystrokes that wait for the next picture."""


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command; return 0, or 2 if it cannot start."""
    options = _parser().parse_args(argv)
    logging.basicConfig(format=f"{NAME}: %(message)s", level=logging.WARNING)
    try:
        layout = load_layout(options.layout)
        typist = Typist(layout, _trials(options, layout), pause_s=options.pause)
        if options.render or options.animate:
            return _render(options, typist)
        path = options.results or Path(time.strftime("typing-%Y%m%d-%H%M%S.csv"))
        if path.exists():
            raise FileExistsError(f"{path} exists; give another name with --results")
        if not path.parent.is_dir():  # found now, not after the first phrase
            raise FileNotFoundError(f"there is no folder {path.parent}; create it first")
        return _run(options, typist, path)
    except (
        ClientError, SoundError, StageError, LayoutError, PhrasesError, OSError,
    ) as error:  # fmt: skip
        print(f"{NAME}: {error}", file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        return 0


class App:
    """The window, the sound and the session."""

    def __init__(
        self, receiver: Receiver, stage: Stage, speakers: Speakers, typist: Typist, save: _Saver
    ) -> None:
        self._receiver, self._stage, self._speakers = receiver, stage, speakers
        self._typist, self._save = typist, save
        self._view = View()
        self._struck: deque[tuple[Struck, float]] = deque(maxlen=MOST_WAITING)
        self._fingers: tuple[Pointer, ...] = ()

    def run(self) -> None:
        """Run until the window is closed."""
        # Keys must sound also while the user drags the window, which stops its thread.
        listen(NAME, self._receiver, self._stage, self._process, self._draw, at_once=True)

    def _process(self, frame: TouchFrame, now_s: float) -> None:
        self._fingers = frame.pointers
        for struck in self._typist.process(frame):
            sound = sound_of(struck)
            if sound is not None:
                self._speakers.send(sound)
            self._struck.append((struck, now_s))

    def _draw(self, now_s: float, note: str) -> None:
        self._stage.pressed()
        placed = self._stage.placed(self._receiver.services, self._receiver.following)
        self._typist.size_mm = (placed.width_mm, placed.height_mm)
        while self._struck:
            self._view.update(*self._struck.popleft())
        shown = self._typist.shown
        self._view.draw(self._stage.screen, placed, shown, self._fingers, now_s, note)
        self._stage.show(self._view.parts)
        self._save.new()


class _Saver:
    """Writes the results after each phrase, so that a crash loses none."""

    def __init__(self, path: Path, typist: Typist, participant: str) -> None:
        self._path, self._typist, self._participant = path, typist, participant
        self._written = 0

    def new(self) -> None:
        """Write the results if a phrase was finished. Raises `OSError`."""
        results = list(self._typist.results)
        if len(results) > self._written:
            write_results(self._path, results, self._participant)
            self._written = len(results)

    def report(self) -> None:
        """Print how it went."""
        if self._written:
            print("\n".join(summary(self._typist.results)))
            print(f"{NAME}: wrote {self._path}")


def _run(options: argparse.Namespace, typist: Typist, path: Path) -> int:
    save = _Saver(path, typist, options.participant)
    backends = [miniaudio.Backend.NULL] if options.silent else []
    with ExitStack() as stack:
        receiver = stack.enter_context(halo_client.connect(options.source))
        stage = stack.enter_context(Stage(NAME, options.full_screen, options.display))
        speakers = stack.enter_context(Speakers(Mixer(key_sounds()), backends, NO_SOUND))
        try:
            App(receiver, stage, speakers, typist, save).run()
        finally:
            typist.finish()
            save.new()
            save.report()
    return 0


def _render(options: argparse.Namespace, typist: Typist) -> int:
    source = halo_client.parse_source(options.source)
    if not isinstance(source, FileSource):
        option = "--render" if options.render else "--animate"
        raise ClientError(f"{option} needs a recorded stream: --from FILE.jsonl")
    frames = list(halo_client.frames(FileSource(source.path, paced=False)))
    text = to_svg(frames, typist)
    typist.finish()
    if options.animate:
        with appearing(options.animate) as file:
            file.write(text.encode())
        print(f"{NAME}: wrote {options.animate}")
    if options.render:
        write_results(options.render, typist.results, options.participant)
        empty = "" if typist.results else "; no phrase was finished, so it has no rows"
        print("\n".join([*summary(typist.results), f"{NAME}: wrote {options.render}{empty}"]))
    return 0


def _trials(options: argparse.Namespace, layout: Layout) -> list[Trial]:
    if options.free:
        return [Trial(FREE_TASK, number + 1, "") for number in range(options.count)]
    characters = {key.character for key in layout.keys}
    phrases = read_phrases(options.phrases, characters) if options.phrases else PHRASES
    seed = (
        int(np.random.SeedSequence().generate_state(1)[0]) if options.seed is None else options.seed
    )
    order = in_order_of_seed(phrases, seed)
    return [
        Trial(task, number + 1, order[(at * options.count + number) % len(order)])
        for at, task in enumerate(options.tasks)
        for number in range(options.count)
    ]


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog=NAME,
        description=DESCRIPTION,
        epilog=EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    add_stage_options(parser)
    parser.add_argument(
        "--layout",
        default=LAYOUTS[0],
        metavar="NAME",
        help=f"{', '.join(LAYOUTS)}, or a file such as mine.toml (%(default)s)",
    )
    parser.add_argument(
        "--phrases", type=Path, metavar="FILE", help="your own phrases, one on each line"
    )
    parser.add_argument("--free", action="store_true", help="type what you want, without phrases")
    parser.add_argument(
        "--tasks",
        type=_names,
        default="balanced",
        metavar="A,B",
        help="names of the tasks, one after the other (%(default)s)",
    )
    parser.add_argument(
        "--count", type=_positive, default=8, metavar="N", help="phrases of each task (%(default)s)"
    )
    parser.add_argument(
        "--seed", type=_whole, metavar="N", help="the same number gives the same order of phrases"
    )
    parser.add_argument(
        "--pause",
        type=_seconds,
        metavar="S",
        help="a phrase also ends after a pause of S seconds, once half of it is typed",
    )
    parser.add_argument("--participant", default="", metavar="NAME", help="a column of the results")
    parser.add_argument(
        "--results", type=Path, metavar="FILE.csv", help="default: typing-DATE-TIME.csv, here"
    )
    parser.add_argument(
        "--silent", action="store_true", help="use no sound device, for a try without loudspeakers"
    )
    parser.add_argument(
        "--render", type=Path, metavar="OUT.csv", help="write the results of --from FILE.jsonl"
    )
    parser.add_argument(
        "--animate",
        type=Path,
        metavar="OUT.svg",
        help="write --from FILE.jsonl as a picture that types itself, for a web page",
    )
    return parser


def _names(text: str) -> tuple[str, ...]:
    names = tuple(dict.fromkeys(name.strip() for name in text.split(",") if name.strip()))
    if not names:
        raise argparse.ArgumentTypeError("give at least one name")
    return names


def _positive(text: str) -> int:
    return round(_number(text, 1))


def _whole(text: str) -> int:
    return round(_number(text, 0))


def _seconds(text: str) -> float:
    return _number(text, 0.2)


def _number(text: str, least: float) -> float:
    try:
        number = float(text)
    except ValueError:
        number = -1.0
    if not least <= number <= 1e9:
        raise argparse.ArgumentTypeError(f"{text!r} is not a number of at least {least:g}")
    return number


if __name__ == "__main__":
    sys.exit(main())
