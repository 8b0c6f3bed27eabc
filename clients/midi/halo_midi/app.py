"""`halo-midi`: fingers as MPE notes.

Rule: input and output only. It opens the port and the window, and passes frames to the pure part.
"""

from __future__ import annotations

import argparse
import logging
import sys
from collections.abc import Callable, Iterable, Sequence
from contextlib import ExitStack
from typing import TYPE_CHECKING, Protocol

import mido

import halo_client
from halo_client import ClientError, FileSource
from halo_midi.errors import MidiError
from halo_midi.layouts import Board, board, note_name
from halo_midi.options import NAME, make_parser, settings
from halo_midi.player import Player
from halo_midi.render import MIDI, SOUND, messages, write
from halo_protocol import Pointer, TouchFrame
from halo_window import StageError, listen

if TYPE_CHECKING:
    from halo_window import Stage


class Output(Protocol):
    """A port, or the terminal."""

    def send(self, messages: Callable[[], Iterable[mido.Message]]) -> None:
        """Send what a function returns."""


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command; return 0, or 2 if it cannot start."""
    options = make_parser().parse_args(argv)
    logging.basicConfig(format=f"{NAME}: %(message)s", level=logging.WARNING)
    try:
        if options.calibrate:
            return _calibrate(options)
        layout = board(options.layout, options.root, options.scale)
        if options.render:
            return _render(options, Player(layout, settings(options)))
        return _play(options, layout, Player(layout, settings(options), repeats=True))
    except (ClientError, MidiError, StageError, OSError) as error:
        print(f"{NAME}: {error}", file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        return 0


def _play(options: argparse.Namespace, layout: Board, player: Player) -> int:
    with ExitStack() as stack:
        receiver = stack.enter_context(halo_client.connect(options.source))
        stage: Stage | None = None
        if options.window or options.full_screen:
            from halo_window import Stage

            stage = stack.enter_context(Stage(NAME, options.full_screen, options.display))
        # Last in, first out: however this ends, the notes end before anything else is closed.
        output = _output(options, player, stack)
        pointers: tuple[Pointer, ...] = ()

        def on_frame(frame: TouchFrame, now_s: float) -> None:
            nonlocal pointers
            output.send(lambda: [each.message for each in player.process(frame)])
            pointers = frame.pointers

        def draw(now_s: float, note: str) -> None:
            if stage is not None:
                from halo_midi.view import draw as draw_keys

                stage.pressed()
                placed = stage.placed(receiver.services, receiver.following)
                draw_keys(stage.screen, placed, layout, pointers, note)
                stage.show()

        listen(NAME, receiver, stage, on_frame, draw, at_once=True)
    return 0


def _output(options: argparse.Namespace, player: Player, stack: ExitStack) -> Output:
    if options.print:
        return _Terminal()
    from halo_midi.port import MidiPort, OwnPort

    ends = (player.opening, player.closing)
    if options.port:
        return stack.enter_context(MidiPort(options.port, *ends))
    port = stack.enter_context(OwnPort(NAME, *ends))
    _say(f"the port {NAME} is open; choose it in your synthesiser or DAW")
    return port


class _Terminal:
    """Prints notes, for a try without MIDI."""

    def send(self, messages: Callable[[], Iterable[mido.Message]]) -> None:
        for each in messages():
            if each.type in ("note_on", "note_off"):
                verb = "starts" if each.type == "note_on" else "ends  "
                name = note_name(each.note)
                print(f"{name:4} {verb} velocity {each.velocity:3} channel {each.channel + 1}")
        sys.stdout.flush()


def _render(options: argparse.Namespace, player: Player) -> int:
    source = halo_client.parse_source(options.source)
    if not isinstance(source, FileSource):
        raise ClientError("--render needs a recorded stream: --from FILE.jsonl")
    if options.render.suffix not in (MIDI, SOUND):
        raise ClientError(f"{options.render} is neither a {MIDI} nor a {SOUND} file")
    frames = halo_client.frames(FileSource(source.path, paced=False))
    write(options.render, messages(frames, player), options.program - 1, options.soundfont)
    print(f"{NAME}: wrote {options.render}")
    return 0


def _calibrate(options: argparse.Namespace) -> int:
    from halo_midi.calibrate import measured

    with halo_client.connect(options.source) as receiver:
        soft, loud = measured(receiver, _say)
    print(f"{NAME}: your curve: {NAME} --soft {soft:.0f} --loud {loud:.0f}")
    return 0


def _say(text: str) -> None:
    print(f"{NAME}: {text}", file=sys.stderr, flush=True)


if __name__ == "__main__":
    sys.exit(main())
