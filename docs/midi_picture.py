"""Draw the picture of clients/midi/README.md: a virtual painter as MPE notes.

    uv run python docs/midi_picture.py

It reads the recorded stream of the tests, and writes clients/midi/take.svg. The same stream gives
the same picture.
"""

from __future__ import annotations

from pathlib import Path

import matplotlib as mpl

mpl.use("svg")  # before pyplot: no window, no display

import matplotlib.pyplot as plt
from matplotlib.axes import Axes

import halo_client
from halo_client import FileSource
from halo_midi.layouts import board, note_name
from halo_midi.player import Player, Sent
from halo_midi.render import messages
from halo_midi.settings import Settings

ROOT = Path(__file__).parents[1]
STREAM = ROOT / "tests" / "clients" / "recorded" / "painting.jsonl"
DARK, LIGHT, GOLD, BLUE, RED = "#0e0e12", "#e8e8ee", "#f0be50", "#78c8ff", "#e15a4b"
BEND = Settings.__dataclass_fields__["bend_semitones"].default

Line = list[tuple[float, float]]
"""Seconds and a value."""


def main() -> None:
    """Draw pitch, pressure and hover."""
    mpl.rcParams["svg.hashsalt"] = "halo"  # the same bytes on every run
    frames = list(halo_client.frames(FileSource(STREAM, paced=False)))
    sent = messages(frames, Player(board("ribbon")))
    figure, (pitch, press, wheel) = plt.subplots(
        3, 1, sharex=True, figsize=(9, 5), height_ratios=(3, 1.2, 1.2), facecolor=DARK
    )
    for line, channel in pitches(sent):
        pitch.plot(*zip(*line, strict=True), color=GOLD, lw=3)
        pitch.text(line[0][0], line[0][1] + 2, f"channel {channel + 1}", color=LIGHT, fontsize=8)
    pitch.set_yticks(range(48, 85, 12), [note_name(each) for each in range(48, 85, 12)])
    pitch.set(ylim=(46, 86), ylabel="pitch")
    press.step(*zip(*values(sent, "aftertouch", None), strict=True), where="post", color=RED)
    press.set(ylim=(-5, 132), ylabel="pressure", yticks=(0, 127))
    wheel.step(*zip(*values(sent, "control_change", 1), strict=True), where="post", color=BLUE)
    wheel.set(ylim=(-5, 132), ylabel="hover", yticks=(0, 127), xlabel="s", xlim=(0.5, 6.8))
    for axis in (pitch, press, wheel):
        dress(axis)
    figure.align_ylabels()
    figure.tight_layout()
    figure.savefig(ROOT / "clients" / "midi" / "take.svg", metadata={"Date": None, "Creator": None})


def pitches(sent: list[Sent]) -> list[tuple[Line, int]]:
    """Return the pitch of each note over time, with its channel."""
    lines: list[tuple[Line, int]] = []
    bends: dict[int, float] = {}
    sounding: dict[int, tuple[int, Line]] = {}
    for each in sent:
        message, at_s = each.message, seconds(sent, each)
        if message.type == "pitchwheel":
            bends[message.channel] = message.pitch / 8192 * BEND
        if message.type == "note_on":
            sounding[message.channel] = (message.note, [])
            lines.append((sounding[message.channel][1], message.channel))
        if message.channel in sounding and message.type in ("note_on", "note_off", "pitchwheel"):
            note, line = sounding[message.channel]
            line.append((at_s, note + bends[message.channel]))
        if message.type == "note_off":
            sounding.pop(message.channel, None)
    return lines


def values(sent: list[Sent], kind: str, control: int | None) -> Line:
    """Return a value over time, of all channels."""
    return [
        (seconds(sent, each), each.message.value)
        for each in sent
        if each.message.type == kind
        and (control is None or (each.message.control, each.message.channel) == (control, 0))
    ]


def seconds(sent: list[Sent], each: Sent) -> float:
    """Time since the first message."""
    return (each.time_us - sent[0].time_us) / 1e6


def dress(axis: Axes) -> None:
    """Use light on dark, without a border."""
    axis.set_facecolor(DARK)
    axis.tick_params(colors=LIGHT, length=0)
    for label in (axis.xaxis.label, axis.yaxis.label):
        label.set_color(LIGHT)
    for spine in axis.spines.values():
        spine.set_visible(False)


if __name__ == "__main__":
    main()
