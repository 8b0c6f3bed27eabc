"""`halo-drums`: tap to play, hover to shape, press to bend.

Rule: input and output only. It opens sound, MIDI and window, and passes frames to the pure part.
"""

from __future__ import annotations

import argparse
import logging
import sys
from collections import deque
from collections.abc import Sequence
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING, Protocol

import halo_client
from halo_client import ClientError, FileSource, Receiver
from halo_client.files import appearing
from halo_drums.bank import make_bank
from halo_drums.errors import SoundError
from halo_drums.kit import KIT, Pad, Settings, mirrored
from halo_drums.player import Gesture, Player
from halo_midi.errors import MidiError
from halo_protocol import TouchFrame
from halo_window import StageError, add_stage_options, listen

if TYPE_CHECKING:
    from halo_window import Stage

NAME = "halo-drums"
DESCRIPTION = "Drums on any table: tap with one hand, shape the sound with the other."
EPILOG = """\
how to drum:
  tap            a pad; faster is louder and brighter
  other hand     hover low for a deep, heavy sound, high for a sharp, snappy one
  keep pressing  bends the toms and the kick, mutes the snare and the hats

examples:
  halo-drums                                    use the touches of `halo serve`
  halo-drums --full-screen --display 1          on the projector, pads under your fingers
  halo-drums --midi fluid                       use a sampler instead, on MIDI channel 10
  halo-drums --from x.jsonl --render x.wav      a recorded stream as a sound file
"""


MOST_SHOWN = 256
"""Gestures that wait for the next picture."""


class Instrument(Protocol):
    """The speakers or a MIDI port."""

    def send(self, gesture: Gesture) -> None:
        """Turn a gesture into sound."""


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command; return 0, or 2 if it cannot start."""
    options = _parser().parse_args(argv)
    logging.basicConfig(format=f"{NAME}: %(message)s", level=logging.WARNING)
    kit = mirrored(KIT) if options.left_handed else KIT
    settings = Settings(low_mm=options.low, high_mm=options.high)
    try:
        if options.render or options.picture or options.animate:
            return _render(options, kit, settings)
        return _play(options, kit, settings)
    except (ClientError, SoundError, MidiError, StageError, OSError) as error:
        print(f"{NAME}: {error}", file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        return 0


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog=NAME,
        description=DESCRIPTION,
        epilog=EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    add_stage_options(parser)
    parser.add_argument("--no-window", action="store_true", help="sound only")
    parser.add_argument("--midi", metavar="PORT", help="play this MIDI port, not the speakers")
    parser.add_argument(
        "--silent", action="store_true", help="use no sound device, for a try without loudspeakers"
    )
    parser.add_argument("--left-handed", action="store_true", help="snare and kick on the left")
    defaults = Settings()
    parser.add_argument(
        "--low",
        type=float,
        default=defaults.low_mm,
        metavar="MM",
        help="hover height of the deepest sound (%(default)g)",
    )
    parser.add_argument(
        "--high",
        type=float,
        default=defaults.high_mm,
        metavar="MM",
        help="hover height of the sharpest sound (%(default)g)",
    )
    parser.add_argument(
        "--render", type=Path, metavar="OUT.wav", help="write the sound of --from FILE.jsonl"
    )
    parser.add_argument(
        "--picture",
        type=Path,
        metavar="OUT.png",
        help="write the loudest moment of --from FILE.jsonl",
    )
    parser.add_argument(
        "--animate",
        type=Path,
        metavar="OUT.svg",
        help="write --from FILE.jsonl as a picture that moves, for a web page",
    )
    return parser


def _render(options: argparse.Namespace, kit: tuple[Pad, ...], settings: Settings) -> int:
    from halo_drums.render import render, write_wav

    source = halo_client.parse_source(options.source)
    if not isinstance(source, FileSource):
        raise ClientError(
            "--render, --picture and --animate need a recorded stream: --from FILE.jsonl"
        )
    frames = list(halo_client.frames(FileSource(source.path, paced=False)))
    if options.render:
        write_wav(options.render, render(frames, kit, settings))
        print(f"{NAME}: wrote {options.render}")
    if options.picture:
        from halo_drums.view import write_picture

        player = Player(kit, settings)
        gestures = [gesture for frame in frames for gesture in player.process(frame)]
        write_picture(options.picture, kit, gestures)
        print(f"{NAME}: wrote {options.picture}")
    if options.animate:
        from halo_drums.animated import to_svg

        with appearing(options.animate) as file:
            file.write(to_svg(frames, kit, settings).encode())
        print(f"{NAME}: wrote {options.animate}")
    return 0


def _play(options: argparse.Namespace, kit: tuple[Pad, ...], settings: Settings) -> int:
    from halo_window import Stage

    with ExitStack() as stack:
        receiver = stack.enter_context(halo_client.connect(options.source))
        instrument = _instrument(options, kit, settings, stack)
        stage = None
        if not options.no_window:
            stage = stack.enter_context(Stage(NAME, options.full_screen, options.display))
        _run(receiver, Player(kit, settings), instrument, stage, kit)
    return 0


def _instrument(
    options: argparse.Namespace, kit: tuple[Pad, ...], settings: Settings, stack: ExitStack
) -> Instrument:
    if options.midi:
        from halo_drums.midi import MidiOut

        return stack.enter_context(MidiOut(options.midi))
    import miniaudio

    from halo_drums.mixer import Mixer
    from halo_drums.speakers import Speakers

    backends = [miniaudio.Backend.NULL] if options.silent else []
    return stack.enter_context(Speakers(Mixer(make_bank(kit), settings), backends))


def _run(
    receiver: Receiver,
    player: Player,
    instrument: Instrument,
    stage: Stage | None,
    kit: tuple[Pad, ...],
) -> None:
    from halo_drums.view import View

    view = View(kit)
    sounding: deque[tuple[Gesture, float]] = deque(maxlen=MOST_SHOWN)

    def on_frame(frame: TouchFrame, now_s: float) -> None:
        for gesture in player.process(frame):
            instrument.send(gesture)
            sounding.append((gesture, now_s))

    def draw(now_s: float, note: str) -> None:
        while sounding:
            view.update(*sounding.popleft())
        if stage is not None:
            stage.pressed()
            placed = stage.placed(receiver.services, receiver.following)
            view.draw(stage.screen, placed, now_s, note)
            stage.show(view.parts)

    # Hits must sound also while the user drags the window, which stops its thread.
    listen(NAME, receiver, stage, on_frame, draw, at_once=True)


if __name__ == "__main__":
    sys.exit(main())
