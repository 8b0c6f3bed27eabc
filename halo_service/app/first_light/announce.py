"""Prompts that can be followed while both hands are over the table: seen and heard.

Seen: on the terminal, and in large letters on a page that reloads itself, for a screen or a
projector. Heard: spoken by the system's own voice where there is one, and tones, which are computed
here and played by the system's own player. Nothing waits for a sound.
"""

from __future__ import annotations

import html
import shutil
import subprocess
import sys
import tempfile
import wave
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np

from halo_calibration.guided.guide import Prompt
from halo_service.files import appearing

PAGE = "now.html"
VOICES = (["say"], ["spd-say", "--wait"], ["espeak-ng"], ["espeak"])
"""Programs that speak their argument: macOS, then Linux."""
PLAYERS = (["afplay"], ["paplay"], ["aplay", "-q"])
"""Programs that play a WAV file."""
TONES_HZ = {"ready": (660.0,), "done": (880.0, 1320.0), "again": (330.0, 330.0)}
_RATE = 22_050
_TONE_S = 0.12


class Announcer:
    """Shows and speaks what to do."""

    def __init__(
        self,
        say: Callable[[str], None],
        page: Path | None = None,
        follow: Callable[[Prompt], None] | None = None,
        sound: bool = True,
    ) -> None:
        """`say` prints a line; `page`: file of the page; `follow`: makes a virtual user follow."""
        self._say, self._page = say, page
        self.follow = follow
        self._voice = _first(VOICES) if sound else None
        self._player = _first(PLAYERS) if sound else None
        self._sound = sound
        self._spoken: subprocess.Popen[bytes] | None = None
        self._folder = tempfile.TemporaryDirectory(prefix="halo-tones-")
        self._tones = {name: self._write(name, hertz) for name, hertz in TONES_HZ.items()}

    def prompt(self, prompt: Prompt, progress: str = "") -> None:
        """Say what to do now."""
        self._say(f"{progress}  {prompt.words}".strip())
        self.speak(prompt.words, progress)
        if self.follow is not None:
            self.follow(prompt)

    def speak(self, words: str, progress: str = "") -> None:
        """Show words in large letters, and speak them."""
        self._show(words, progress)
        self._speak(words)

    def say(self, words: str) -> None:
        """Say how something went."""
        self._say(words)

    def tone(self, name: str) -> None:
        """Play `ready`, `done` or `again`."""
        if not self._sound:
            return
        if self._player is not None:
            _start([*self._player, str(self._tones[name])])
        elif sys.platform == "win32":
            import winsound

            winsound.PlaySound(str(self._tones[name]), winsound.SND_FILENAME | winsound.SND_ASYNC)
        else:
            sys.stderr.write("\a")
            sys.stderr.flush()

    def close(self) -> None:
        """Remove the page and the tones."""
        self._folder.cleanup()
        if self._page is not None:
            self._page.unlink(missing_ok=True)

    def _speak(self, words: str) -> None:
        if self._voice is None:
            return
        if self._spoken is not None and self._spoken.poll() is None:
            self._spoken.terminate()  # the newest prompt counts
        self._spoken = _start([*self._voice, words])

    def _show(self, words: str, progress: str) -> None:
        if self._page is None:
            return
        with appearing(self._page) as file:
            file.write(page_of(words, progress).encode())

    def _write(self, name: str, hertz: Sequence[float]) -> Path:
        path = Path(self._folder.name) / f"{name}.wav"
        write_tone(path, hertz)
        return path


def page_of(words: str, progress: str) -> str:
    """Return the page: one sentence in large letters, loaded again each second."""
    return (
        "<!doctype html><html lang='en'><head><meta charset='utf-8'>"
        "<meta http-equiv='refresh' content='1'><title>halo first-light</title><style>"
        "body{margin:0;height:100vh;display:grid;place-content:center;background:#111;color:#fff;"
        "font:600 7vw/1.3 system-ui,sans-serif;text-align:center;padding:0 5vw}"
        "small{font-size:3vw;font-weight:400;color:#aaa}</style></head><body>"
        f"<div>{html.escape(words)}</div><small>{html.escape(progress)}</small></body></html>\n"
    )


def write_tone(path: Path, hertz: Sequence[float]) -> None:
    """Write a WAV file of tones, one after the other, without clicks at their ends."""
    times_s = np.arange(round(_TONE_S * _RATE)) / _RATE
    fade = np.minimum(1.0, np.minimum(times_s, _TONE_S - times_s) / 0.01)
    parts = [0.4 * fade * np.sin(2.0 * np.pi * each * times_s) for each in hertz]
    with wave.open(str(path), "wb") as file:
        file.setnchannels(1)
        file.setsampwidth(2)
        file.setframerate(_RATE)
        file.writeframes((np.concatenate(parts) * 32_767).astype("<i2").tobytes())


def _first(programs: Sequence[list[str]]) -> list[str] | None:
    return next((each for each in programs if shutil.which(each[0])), None)


def _start(command: list[str]) -> subprocess.Popen[bytes] | None:
    """Start a program and forget it; a sound that cannot be played is no fault."""
    try:
        return subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    except OSError:
        return None
