"""A recorded stream as a picture that types itself.

Rule: pure text. `--animate OUT.svg` writes it.
"""

from __future__ import annotations

from collections.abc import Sequence
from html import escape

from halo_protocol import TouchFrame
from halo_type.layout import SPACE, Key
from halo_type.typist import Struck, Typist
from halo_window.animated import Animation

BACKGROUND, KEY, EDGE = "#0e0e12", "#262834", "#565a6e"
INK, TEXT, FAINT, STRUCK = "#ebebf0", "#ffeb96", "#9698a5", "#46bebe"
GLOW_US = 250_000
FITS = 44
"""Characters in a line of 10 mm; a longer phrase is smaller."""
LINES_MM = (18.0, 38.0, 56.0)
"""Where the lines of text are: figures, phrase, text."""


def to_svg(frames: Sequence[TouchFrame], typist: Typist) -> str:
    """Return the text of a file."""
    struck: list[Struck] = []
    states: list[tuple[int, tuple[str, str, str]]] = []
    for frame in frames:
        struck += typist.process(frame)
        state = _state(typist)
        if not states or states[-1][1] != state:
            states.append((frame.time_us, state))
    animation = Animation.of(frames, *typist.size_mm)
    for character, key in typist.shown.keys.items():
        mine = [each.time_us for each in struck if each.character == character]
        animation.lines += _key(animation, key, mine)
    left_mm = min(key.x_mm for key in typist.shown.keys.values())
    for line, (y_mm, colour) in enumerate(zip(LINES_MM, (FAINT, INK, TEXT), strict=True)):
        texts = [(at, state[line]) for at, state in states]
        longest = max((len(text) for _, text in texts), default=0)
        size = 7.0 if line == 0 else 10.0 * min(1.0, FITS / max(longest, 1))
        animation.lines += _texts(animation, texts, left_mm, y_mm, colour, size)
    animation.fingers(frames, STRUCK)
    return animation.text(BACKGROUND)


def _state(typist: Typist) -> tuple[str, str, str]:
    shown, last = typist.shown, ""
    if shown.last is not None:
        done = shown.last.typed
        last = f"last phrase: {done.wpm:.0f} words a minute, {100 * done.accuracy:.0f} % right"
    return last, "" if shown.trial is None else shown.trial.presented, shown.text


def _texts(
    animation: Animation,
    texts: Sequence[tuple[int, str]],
    x_mm: float,
    y_mm: float,
    colour: str,
    size: float,
) -> list[str]:
    """A line of text that changes: an element for each of its states."""
    changed = [
        (at, text) for n, (at, text) in enumerate(texts) if n == 0 or texts[n - 1][1] != text
    ]
    ends = [at for at, _ in changed[1:]] + [animation.end_us]
    return [
        f'<text x="{x_mm:g}" y="{y_mm:g}" fill="{colour}" font-size="{size:g}" opacity="0" '
        f'xml:space="preserve">{escape(text)}{animation.shown(at, end)}</text>'
        for (at, text), end in zip(changed, ends, strict=True)
        if text and end > animation.begin_us
    ]


def _key(animation: Animation, key: Key, struck_us: Sequence[int]) -> list[str]:
    area = (
        f'x="{key.x_mm + 0.7:g}" y="{key.y_mm + 0.7:g}" width="{key.width_mm - 1.4:g}" '
        f'height="{key.height_mm - 1.4:g}" rx="1.5"'
    )
    lines = [f'<rect {area} fill="{KEY}" stroke="{EDGE}" stroke-width="0.3"/>']
    if struck_us:
        points = [(animation.begin_us, 0.0)]
        for at in struck_us:
            points = [each for each in points if each[0] < at - 1000]
            points += [(at - 1000, 0.0), (at, 1.0), (at + GLOW_US, 0.0)]
        glow = animation.moving("opacity", points)
        lines.append(f'<rect {area} fill="{STRUCK}" opacity="0">{glow}</rect>')
    if key.character != SPACE:
        size = 8.0 if len(key.character) == 1 else 5.0
        x, y = key.middle
        lines.append(
            f'<text x="{x:g}" y="{y + 0.35 * size:g}" fill="{INK}" font-size="{size:g}" '
            f'text-anchor="middle">{escape(key.character)}</text>'
        )
    return lines
