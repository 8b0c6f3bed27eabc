"""A recorded stream as a MIDI file, or as sound through `fluidsynth`.

Rule: no clock, no port. A note starts at the time of its touch; live, it starts when its frame
arrives. The MIDI file is plain MPE; only the copy for `fluidsynth`, which has no MPE, selects a
sound on each channel.
"""

from __future__ import annotations

import shutil
import subprocess
import tempfile
from collections import defaultdict
from collections.abc import Iterable
from pathlib import Path

import mido

from halo_client.files import appearing
from halo_midi.errors import MidiError
from halo_midi.player import Player, Sent
from halo_protocol import TouchFrame

TICKS, TEMPO_US = 960, 500_000
"""Ticks in a quarter note, and its length at 120 beats a minute: a tick is 0.52 ms."""
TAIL_US = 1_500_000
"""Time for the last note to ring."""
RATE = 48_000
GAIN = "0.6"
"""Three times the default of `fluidsynth`, which is for many notes at once."""
SOUNDFONTS = (
    "/usr/share/sounds/sf2/default-GM.sf2",
    "/usr/share/sounds/sf2/TimGM6mb.sf2",
    "/usr/share/sounds/sf2/FluidR3_GM.sf2",
    "/usr/share/soundfonts/default.sf2",
    "/usr/share/soundfonts/FluidR3_GM.sf2",
    "/opt/homebrew/share/soundfonts/default.sf2",
)
"""Where Debian, Fedora, Arch and Homebrew put one."""
MIDI, SOUND = ".mid", ".wav"


def messages(frames: Iterable[TouchFrame], player: Player) -> list[Sent]:
    """Return all messages of a stream in order of time, from zone to silence."""
    sent: list[Sent] = []
    last_us = 0
    for frame in frames:
        if not sent:
            sent += [Sent(frame.time_us, each) for each in player.opening()]
        sent += player.process(frame)
        last_us = frame.time_us
    if sent:
        sent += [Sent(last_us, each) for each in player.closing()]
    return _in_order(sent)


def midi_file(sent: list[Sent]) -> mido.MidiFile:
    """Return a file with one track; time 0 is the first message."""
    file = mido.MidiFile(type=0, ticks_per_beat=TICKS)
    track = mido.MidiTrack()
    file.tracks.append(track)
    track.append(mido.MetaMessage("set_tempo", tempo=TEMPO_US))
    before = 0
    for each in sent:
        at = round((each.time_us - sent[0].time_us) * TICKS / TEMPO_US)
        track.append(each.message.copy(time=at - before))
        before = at
    track.append(mido.MetaMessage("end_of_track", time=round(TAIL_US * TICKS / TEMPO_US)))
    return file


def write(path: Path, sent: list[Sent], program: int, soundfont: Path | None) -> None:
    """Write a `.mid` or `.wav` file. Raises `MidiError` and `OSError`."""
    with appearing(path) as file:
        if path.suffix == SOUND:
            with tempfile.TemporaryDirectory() as folder:
                file.write(_sound(Path(folder), sent, program, soundfont).read_bytes())
        else:
            midi_file(sent).save(file=file)


def _in_order(sent: list[Sent]) -> list[Sent]:
    """Sort by time; what came before a message on its channel stays before it.

    A touch is up to some frames older than the frame that reports it. What was sent to its channel
    meanwhile, for the hovering finger, moves to the time of the touch.
    """
    times = [each.time_us for each in sent]
    by_channel: dict[int, list[int]] = defaultdict(list)
    for number, each in enumerate(sent):
        earlier = by_channel[each.message.channel]
        for other in reversed(earlier):
            if times[other] <= each.time_us:
                break
            times[other] = each.time_us
        earlier.append(number)
    order = sorted(range(len(sent)), key=lambda number: times[number])
    return [Sent(times[number], sent[number].message) for number in order]


def _sound(folder: Path, sent: list[Sent], program: int, soundfont: Path | None) -> Path:
    synth = shutil.which("fluidsynth")
    if synth is None:
        raise MidiError(
            "a .wav file needs fluidsynth, which is not installed (Debian: apt install fluidsynth "
            "timgm6mb-soundfont; macOS: brew install fluid-synth); a .mid file needs nothing"
        )
    font = soundfont or next((Path(each) for each in SOUNDFONTS if Path(each).exists()), None)
    if font is None or not font.exists():
        raise MidiError(
            f"no soundfont {font or 'is installed'}; name one with --soundfont FILE.sf2 "
            "(Debian: apt install timgm6mb-soundfont)"
        )
    score, sound = folder / f"score{MIDI}", folder / f"sound{SOUND}"
    midi_file([*_sounds(sent, program), *sent]).save(score)
    # In its mode `xg`, bank 0 makes channel 10 a melodic one, as MPE needs it.
    options = ["-ni", "-q", "-r", str(RATE), "-g", GAIN, "-o", "synth.midi-bank-select=xg"]
    command = [synth, *options, "-F", str(sound), str(font), str(score)]
    run = subprocess.run(command, capture_output=True, text=True, check=False)
    if run.returncode or not sound.exists():
        raise MidiError(f"fluidsynth failed: {run.stderr.strip() or run.stdout.strip()}")
    return sound


def _sounds(sent: list[Sent], program: int) -> list[Sent]:
    """Bank and sound of each channel, before everything else."""
    if not sent:
        return []
    start_us = sent[0].time_us
    chosen = []
    for channel in range(16):
        bank = mido.Message("control_change", channel=channel, control=0, value=0)
        chosen += [bank, mido.Message("program_change", channel=channel, program=program)]
    return [Sent(start_us, each) for each in chosen]
