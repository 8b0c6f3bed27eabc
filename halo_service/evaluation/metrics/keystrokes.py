"""Typing: which key was struck, which key was reported, and which text results.

The virtual typist strikes each character of a phrase once and never deletes: errors come from the
hand's own scatter and from the sensing. So keys count only where the finger landed well inside
one, and the report compares the text with what a perfect sensor would have typed.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import accumulate
from math import dist

from halo_service.evaluation.metrics.touches import Down, Touches, fits
from halo_service.evaluation.metrics.truth import TrueTouch
from halo_service.virtual.scenarios.typing import keys
from halo_type.layout import key_at
from halo_type.metrics import Entry, Typed, typed

INSIDE_MM = 2.0
"""A finger that landed this far inside a key aimed at that key."""
PAUSE_US = 1_600_000
"""The typist pauses longer between two phrases, and never within one."""
SHORTEST = 5
"""Characters; a shorter piece at the recording's end is no phrase."""


@dataclass(frozen=True, slots=True)
class Keys:
    """Keystrokes that landed well inside a key."""

    struck: int = 0
    wrong: int = 0
    """Reported as another key, or as none."""
    missed: int = 0
    doubled: int = 0
    """Further downs for those keystrokes that would have typed another character."""


@dataclass(frozen=True, slots=True)
class Phrase:
    """One phrase as it was typed."""

    presented: str
    typed: Typed
    perfect: Typed
    """What a perfect sensor would have typed from the same touches."""


def score_keys(touches: Touches) -> Keys:
    """Count the keystrokes."""
    layout = keys()
    inside = [hit for hit in touches.hits if _inside(hit.touch)]
    return Keys(
        len(inside) + sum(_inside(touch) for touch in touches.missed),
        sum(key_at(layout, hit.down.x_mm, hit.down.y_mm) != hit.touch.key for hit in inside),
        sum(_inside(touch) for touch in touches.missed),
        sum(
            key_at(layout, down.x_mm, down.y_mm) is not None and _inside(_struck(down, touches))
            for down in touches.doubled
        ),
    )


def score_phrases(touches: Touches) -> tuple[Phrase, ...]:
    """Evaluate every phrase that was typed."""
    touched = [hit.touch for hit in touches.hits]
    touched += [*touches.missed, *touches.between_frames]
    struck = sorted((t for t in touched if t.key is not None), key=lambda t: t.from_us)
    downs = [hit.down for hit in touches.hits]
    downs += [*touches.doubled, *touches.outside, *touches.ghosts]
    reported = sorted((down.time_us, down.x_mm, down.y_mm) for down in downs)
    phrases = [phrase for phrase in _phrases(struck) if len(phrase) >= SHORTEST]
    return tuple(_phrase(phrase, reported) for phrase in phrases)


def _struck(down: Down, touches: Touches) -> TrueTouch | None:
    """Return the touch that a further down repeats: the nearest of those it fits."""
    struck = [*(hit.touch for hit in touches.hits), *touches.missed, *touches.between_frames]
    return min(
        (touch for touch in struck if fits(down, touch)),
        key=lambda touch: dist((down.x_mm, down.y_mm), (touch.x_mm, touch.y_mm)),
        default=None,
    )


def _inside(touch: TrueTouch | None) -> bool:
    """Whether a finger landed well inside the key that it aimed at."""
    if touch is None or touch.key is None:
        return False
    x, y = touch.x_mm, touch.y_mm
    return keys()[touch.key].inside(x, y) >= INSIDE_MM


def _phrases(struck: Sequence[TrueTouch]) -> list[list[TrueTouch]]:
    phrases: list[list[TrueTouch]] = []
    for touch in struck:
        if not phrases or touch.from_us - phrases[-1][-1].from_us > PAUSE_US:
            phrases.append([])
        phrases[-1].append(touch)
    return phrases


def _phrase(phrase: Sequence[TrueTouch], reported: Sequence[tuple[int, float, float]]) -> Phrase:
    presented = "".join(touch.key or "" for touch in phrase)
    begin, end = phrase[0].from_us - PAUSE_US // 2, phrase[-1].from_us + PAUSE_US // 2
    true = [(touch.from_us, touch.x_mm, touch.y_mm) for touch in phrase]
    return Phrase(
        presented,
        typed(presented, _entries(each for each in reported if begin <= each[0] <= end)),
        typed(presented, _entries(true)),
    )


def _entries(strokes: Iterable[tuple[int, float, float]]) -> list[Entry]:
    """Return the text after each stroke; a stroke outside the keyboard types nothing."""
    layout = keys()
    hit = [(time_us, key_at(layout, x, y)) for time_us, x, y in strokes]
    on = [(time_us, key) for time_us, key in hit if key is not None]
    texts = accumulate(key for _, key in on)
    return [Entry(time_us / 1e6, text) for (time_us, _), text in zip(on, texts, strict=True)]
