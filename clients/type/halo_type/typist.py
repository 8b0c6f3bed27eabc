"""From frames to text: which key each touch strikes, and when a phrase is done.

Rule: pure. Frames come in, keystrokes and results go out, each with its time on the frames' clock.
A key counts when the finger comes down, as on a tablet.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

from halo_client import Began, touches
from halo_client.picture import HEIGHT_MM, WIDTH_MM
from halo_protocol import TouchFrame
from halo_type.layout import DELETE, DONE, Key, Layout, key_at
from halo_type.metrics import Entry, Typed, typed

TOP = 0.35
"""The keyboard's far edge over the surface's height: text goes above it."""
LONGEST = 400
"""Characters of one text; more are ignored."""


@dataclass(frozen=True, slots=True)
class Trial:
    """One phrase to type."""

    task: str
    number: int
    """From 1, within its task."""
    presented: str
    """Empty: any text."""


@dataclass(frozen=True, slots=True)
class Struck:
    """A touch on the keyboard."""

    time_us: int
    character: str | None
    """None: no key."""
    x_mm: float
    y_mm: float


@dataclass(frozen=True, slots=True)
class Result:
    """A phrase as it was typed."""

    trial: Trial
    transcribed: str
    seconds: float
    """From the first key to the last."""
    typed: Typed


@dataclass(slots=True)
class Typist:
    """A session of typing. `process` runs in one thread; others may read `shown`."""

    layout: Layout
    trials: Sequence[Trial]
    pause_s: float | None = None
    """A phrase ends after such a pause, once half of it is typed; None: with the key `done`."""
    size_mm: tuple[float, float] = (WIDTH_MM, HEIGHT_MM)
    results: list[Result] = field(default_factory=list)
    shown: Shown = field(init=False)
    _entries: list[Entry] = field(default_factory=list)
    _keys: dict[str, Key] = field(default_factory=dict)
    _placed_for: tuple[float, float] = (0.0, 0.0)

    def __post_init__(self) -> None:
        self._place()
        self._show()

    def process(self, frame: TouchFrame) -> list[Struck]:
        """Return the keystrokes of a frame, in order of time."""
        self._place()
        self._end_after_pause(frame.time_us)
        begun = [touch for touch in touches(frame) if isinstance(touch, Began)]
        struck = [self._strike(touch) for touch in sorted(begun, key=lambda each: each.time_us)]
        for each in struck:
            self._enter(each)
        self._show()
        return struck

    def finish(self) -> None:
        """End the last phrase of a session if all of it is typed; half a phrase is no result."""
        if self._trial is not None and len(self._text) >= max(1, len(self._trial.presented)):
            self._end_phrase()
        self._show()

    @property
    def _trial(self) -> Trial | None:
        done = len(self.results)
        return self.trials[done] if done < len(self.trials) else None

    @property
    def _text(self) -> str:
        return self._entries[-1].text if self._entries else ""

    def _strike(self, touch: Began) -> Struck:
        x, y = touch.down.u * self._placed_for[0], touch.down.v * self._placed_for[1]
        return Struck(touch.time_us, key_at(self._keys, x, y), x, y)

    def _enter(self, struck: Struck) -> None:
        before = self._text
        if self._trial is None or struck.character is None:
            return
        if struck.character == DONE:
            self._end_phrase()
            return
        after = before[:-1] if struck.character == DELETE else before + struck.character
        if after != before and len(after) <= LONGEST:
            self._entries.append(Entry(struck.time_us / 1e6, after))

    def _end_after_pause(self, now_us: int) -> None:
        if self.pause_s is None or not self._entries or self._trial is None:
            return
        enough = len(self._text) >= len(self._trial.presented) / 2.0
        if enough and now_us / 1e6 - self._entries[-1].time_s > self.pause_s:
            self._end_phrase()

    def _end_phrase(self) -> None:
        if self._trial is None or not self._text:
            return
        presented = self._trial.presented or self._text  # any text is right where none is given
        seconds = self._entries[-1].time_s - self._entries[0].time_s
        scores = typed(presented, self._entries)
        self.results.append(Result(self._trial, self._text, seconds, scores))
        self._entries = []

    def _place(self) -> None:
        """Place the keyboard, again if the size of the surface changed."""
        if self.size_mm != self._placed_for:
            self._placed_for = width_mm, height_mm = self.size_mm
            left_mm = (width_mm - self.layout.width_mm) / 2.0
            self._keys = self.layout.placed(left_mm, TOP * height_mm)

    def _show(self) -> None:
        last = self.results[-1] if self.results else None
        self.shown = Shown(self._trial, self._text, self._keys, last)


@dataclass(frozen=True, slots=True)
class Shown:
    """What the picture shows."""

    trial: Trial | None
    """None: all phrases are done."""
    text: str
    keys: dict[str, Key]
    last: Result | None
    """Of the phrase before."""
