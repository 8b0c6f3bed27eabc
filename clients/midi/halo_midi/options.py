"""The command line of `halo-midi`, in a musician's words.

Rule: text to values; nothing is opened here.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable
from pathlib import Path

from halo_client import ClientError
from halo_midi.layouts import LAYOUTS, SCALES, note_number
from halo_midi.settings import Settings, Slide
from halo_window import add_stage_options

NAME = "halo-midi"
DESCRIPTION = "Fingers on any table as MPE notes, for any synthesiser or DAW."
EPILOG = """\
how to use it:
  strike         starts a note; faster is louder
  press          channel pressure: swells, brightens, whatever your sound does with it
  side to side   bends the pitch
  near to far    slide (controller 74)
  lift           ends the note; faster gives a higher release velocity
  hover          before and between notes: the modulation wheel follows the lowest finger

layouts (--layout):
{layouts}

examples:
  halo-midi                                     a new MIDI port "halo-midi" for your DAW
  halo-midi --port Surge --layout keys          an open synthesiser, piano keys
  halo-midi --layout scale --scale blues --root E3
  halo-midi --print                             the notes as text, without MIDI
  halo-midi --from x.jsonl --render take.mid    a recorded stream as a MIDI file (or take.wav)
"""
DEFAULTS = Settings()


def make_parser() -> argparse.ArgumentParser:
    """Return the parser."""
    rows = [f"  {row.name:<10} {row.notes}; x {row.moves}" for row in LAYOUTS.values()]
    parser = argparse.ArgumentParser(
        prog=NAME,
        description=DESCRIPTION,
        epilog=EPILOG.format(layouts="\n".join(rows)),
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    add_stage_options(parser)
    parser.add_argument("--window", action="store_true", help="show the layout in a window")
    where = parser.add_argument_group("where the notes go")
    where.add_argument(
        "--port", metavar="NAME", help="a MIDI port that exists (a part of its name is enough)"
    )
    where.add_argument("--print", action="store_true", help="print the notes; needs no MIDI")
    where.add_argument(
        "--render", type=Path, metavar="FILE", help="write --from FILE.jsonl as .mid or .wav"
    )
    where.add_argument(
        "--program", type=_within(1, 128), default=1, metavar="N",
        help="General MIDI sound of a .wav file, 1 to 128 (%(default)s)",
    )  # fmt: skip
    where.add_argument("--soundfont", type=Path, metavar="FILE", help="soundfont of a .wav file")
    _add_notes(parser.add_argument_group("notes"))
    _add_expression(parser.add_argument_group("expression"))
    return parser


def settings(options: argparse.Namespace) -> Settings:
    """Return what the options set. Raises `ClientError`."""
    if options.loud <= options.soft:
        raise ClientError(f"--loud {options.loud:g} must be above --soft {options.soft:g}")
    return Settings(
        options.channels,
        options.bend,
        Slide(options.slide),
        options.hover_cc,
        options.reach,
        options.soft,
        options.loud,
        options.full_press,
    )


def _add_notes(notes: argparse._ArgumentGroup) -> None:
    notes.add_argument("--layout", choices=tuple(LAYOUTS), default="grid", help="see below")
    notes.add_argument("--root", type=_note, metavar="NOTE", help="lowest note, such as C3 or F#2")
    notes.add_argument(
        "--scale", choices=tuple(SCALES), default="major", help="of the layout 'scale'"
    )
    notes.add_argument(
        "--channels", type=_within(1, 15), default=DEFAULTS.members, metavar="N",
        help="MPE member channels, from channel 2 on (%(default)s)",
    )  # fmt: skip


def _add_expression(group: argparse._ArgumentGroup) -> None:
    group.add_argument(
        "--calibrate", action="store_true", help="measure your strikes, print --soft and --loud"
    )
    group.add_argument(
        "--soft", type=float, default=DEFAULTS.soft_mm_s, metavar="MM_S",
        help="strike speed of the softest note, mm/s (%(default)g)",
    )  # fmt: skip
    group.add_argument(
        "--loud", type=float, default=DEFAULTS.loud_mm_s, metavar="MM_S",
        help="strike speed of velocity 127, mm/s (%(default)g)",
    )  # fmt: skip
    group.add_argument(
        "--full-press", type=_above_zero, default=DEFAULTS.full_pressure, metavar="P",
        help="pressure of value 127; 1 is the calibrated medium press (%(default)g)",
    )  # fmt: skip
    group.add_argument(
        "--bend", type=_within(1, 96), default=DEFAULTS.bend_semitones, metavar="N",
        help="pitch bend range in semitones; the same in your synthesiser (%(default)s)",
    )  # fmt: skip
    group.add_argument(
        "--slide", choices=[each.value for each in Slide], default=DEFAULTS.slide.value,
        help="what moves controller 74: y, the height of a hovering finger, or nothing (y)",
    )  # fmt: skip
    group.add_argument(
        "--hover-cc", type=_within(0, 119), default=DEFAULTS.hover_control, metavar="N",
        help="controller on channel 1 that hovering moves; 0: none (%(default)s, modulation)",
    )  # fmt: skip
    group.add_argument(
        "--reach", type=_above_zero, default=DEFAULTS.reach_mm, metavar="MM",
        help="height up to which hovering counts (%(default)g)",
    )  # fmt: skip


def _note(text: str) -> int:
    try:
        return note_number(text)
    except ValueError:
        raise argparse.ArgumentTypeError(
            f"{text!r} is not a note; use C3, F#2, Bb4 or 0 to 127"
        ) from None


def _within(low: int, high: int) -> Callable[[str], int]:
    def read(text: str) -> int:
        if not text.isdigit() or not low <= int(text) <= high:
            raise argparse.ArgumentTypeError(f"{text!r} is not a number from {low} to {high}")
        return int(text)

    return read


def _above_zero(text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = 0.0
    if not 0.0 < value < float("inf"):
        raise argparse.ArgumentTypeError(f"{text!r} is not a number above 0")
    return value
