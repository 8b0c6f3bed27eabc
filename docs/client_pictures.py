"""Draw the pictures of the clients' READMEs: virtual hands, sensed by the service.

    uv run python docs/client_pictures.py [FOLDER]

Writes painting.svg, session.svg and three animated.svg into the folders of the clients; with a
folder, also the streams and the sound in it. Takes a few minutes; the same code gives the same
pictures.
"""

from __future__ import annotations

import sys
import tempfile
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path
from typing import Literal

import matplotlib as mpl

mpl.use("svg")  # before pyplot: no window, no display

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes

import halo_client
from halo_client import FileSource
from halo_client.picture import HEIGHT_MM, WIDTH_MM
from halo_drums.animated import to_svg as animated_drumming
from halo_drums.kit import KIT
from halo_drums.kit import Settings as DrumSettings
from halo_drums.player import Hit, Player, Shape
from halo_drums.render import render, write_wav
from halo_drums.voices import RATE
from halo_paint.animated import to_svg as animated_painting
from halo_paint.painter import Painter
from halo_paint.render import painted, save
from halo_protocol import TouchFrame
from halo_service.app.hand_detector import HandDetector
from halo_service.app.virtual_user.profile import virtual_profile
from halo_service.outputs.jsonl import frame_line
from halo_service.runtime.method import OURS
from halo_service.runtime.replay import replay
from halo_service.settings import Settings
from halo_service.sources import EndOfSource
from halo_service.values import Frame
from halo_service.virtual.offline import SimulatedRecording
from halo_service.virtual.sim_url import parse_sim_url
from halo_type.animated import to_svg as animated_typing
from halo_type.layout import load_layout
from halo_type.phrases import PHRASES, in_order_of_seed
from halo_type.typist import Trial, Typist

CLIENTS = Path(__file__).parents[1] / "clients"
PAINTING, DRUMMING, TYPING = "sim:painting?seed=3", "sim:drumming?seed=3", "sim:typing?seed=3"
PAINTING_S, DRUMMING_S, TYPING_S = 14.0, 7.5, 37.0
TYPING_SEED, PAUSE_S = 3, 1.6
"""The seed of the virtual typist gives the phrases; it presses no key between two of them."""
DARK, LIGHT = "#0e0e12", "#e8e8ee"
TALLEST = 300.0
"""Area of the loudest hit's dot, in points."""


class RecordingSource:
    """A virtual recording as a source."""

    kind: Literal["virtual"] = "virtual"

    def __init__(self, recording: SimulatedRecording) -> None:
        self.camera = recording.camera
        self._frames: Iterator[Frame] = (frame for frame, _ in recording if frame is not None)

    def read(self, timeout_s: float) -> Frame:
        """Return the next frame at once."""
        for frame in self._frames:
            return frame
        raise EndOfSource

    def close(self) -> None:
        """Nothing is open."""


def sensed(name: str, seconds: float, path: Path) -> list[TouchFrame]:
    """Sense a scenario, write its stream to `path`, and return what a client receives."""
    request = parse_sim_url(name)
    source = RecordingSource(SimulatedRecording(request, seconds, colour=False))
    profile = virtual_profile(request.room, Settings())
    with closing(HandDetector(source.camera, profile, Settings().tracking)) as detector:
        state = OURS.start(profile, Settings().sensing)
        frames = replay(source, detector.detect, OURS, state)
        path.write_text("".join(frame_line(each, "sim", "s1", n) for n, each in enumerate(frames)))
    return list(halo_client.frames(FileSource(path, paced=False)))


def draw_session(frames: list[TouchFrame], folder: Path) -> None:
    """Draw hits on their pads, the height of the other hand, and the resulting sound."""
    player = Player()
    gestures = [gesture for frame in frames for gesture in player.process(frame)]
    sound = render(frames)
    write_wav(folder / "drumming.wav", sound)
    first_us = frames[0].time_us
    figure, (pads, hand, wave) = plt.subplots(
        3, 1, sharex=True, figsize=(9, 5), height_ratios=(3, 1.2, 1.2), facecolor=DARK
    )
    for row, pad in enumerate(KIT):
        hits = [each for each in gestures if isinstance(each, Hit) and each.pad.name == pad.name]
        at_s = [(each.time_us - first_us) / 1e6 for each in hits]
        colour = tuple(part / 255 for part in pad.colour)
        pads.axhline(row, color=colour, lw=0.6, alpha=0.5)
        pads.scatter(at_s, [row] * len(hits), [TALLEST * each.level for each in hits], [colour])
    pads.set_yticks(range(len(KIT)), [pad.name for pad in KIT])
    shapes = [each for each in gestures if isinstance(each, Shape)]
    hand.plot([(each.time_us - first_us) / 1e6 for each in shapes],
              [each.height for each in shapes], color="#ffeb96")  # fmt: skip
    hand.set(ylim=(-0.05, 1.05), ylabel="other hand")
    hand.set_yticks((0, 1), ("deep", "sharp"))
    # One point per 4 ms is the resolution of the picture.
    pieces = np.abs(sound[: len(sound) // 192 * 192]).max(axis=1).reshape(-1, 192).max(axis=1)
    times = np.arange(len(pieces)) * 192 / RATE
    wave.fill_between(times, -pieces, pieces, color=LIGHT, lw=0)
    wave.set(xlabel="s", ylabel="sound", yticks=())
    # The session starts with an empty table.
    begin_s = min(each.time_us - first_us for each in gestures) / 1e6
    wave.set_xlim(begin_s - 0.2, times[-1])
    for axis in (pads, hand, wave):
        dress(axis)
    figure.align_ylabels()
    figure.tight_layout()
    figure.savefig(CLIENTS / "drums" / "session.svg", metadata={"Date": None, "Creator": None})


def dress(axis: Axes) -> None:
    """Use light on dark, without a border."""
    axis.set_facecolor(DARK)
    axis.tick_params(colors=LIGHT, length=0)
    for label in (axis.xaxis.label, axis.yaxis.label):
        label.set_color(LIGHT)
    for spine in axis.spines.values():
        spine.set_visible(False)


def main(folder: Path) -> None:
    """Draw all pictures."""
    mpl.rcParams["svg.hashsalt"] = "halo"  # the same bytes on every run
    painting = sensed(PAINTING, PAINTING_S, folder / "painting.jsonl")
    strokes = painted(painting, Painter(vary=True))
    save(CLIENTS / "paint" / "painting.svg", strokes, WIDTH_MM, HEIGHT_MM)
    drumming = sensed(DRUMMING, DRUMMING_S, folder / "drumming.jsonl")
    draw_session(drumming, folder)
    typing = sensed(TYPING, TYPING_S, folder / "typing.jsonl")
    phrases = in_order_of_seed(PHRASES, TYPING_SEED)
    trials = [Trial("balanced", number + 1, phrase) for number, phrase in enumerate(phrases)]
    typist = Typist(load_layout("qwerty"), trials, pause_s=PAUSE_S)
    for client, text in (
        ("paint", animated_painting(painting, Painter(vary=True), WIDTH_MM, HEIGHT_MM)),
        ("drums", animated_drumming(drumming, KIT, DrumSettings())),
        ("type", animated_typing(typing, typist)),
    ):
        (CLIENTS / client / "animated.svg").write_text(text, encoding="utf-8")


if __name__ == "__main__":
    if len(sys.argv) > 1:
        main(Path(sys.argv[1]))
    else:
        with tempfile.TemporaryDirectory() as folder:
            main(Path(folder))
