"""A recorded stream as a picture that moves: hits on their pads, and the other hand's height.

Rule: pure text. `--animate OUT.svg` writes it.
"""

from __future__ import annotations

from collections.abc import Sequence

from halo_client.picture import HEIGHT_MM, WIDTH_MM
from halo_drums.kit import Pad, Settings
from halo_drums.player import Hit, Player, Shape
from halo_protocol import TouchFrame
from halo_window.animated import Animation, changes, rgb

BACKGROUND, FINGER = "#0e0e12", "#e8e8ee"
LOW, HIGH = "#466eff", "#ffeb96"
GLOW_US, RING_US, GROWN_MM = 450_000, 600_000, 26.0
BAR_MM = 4.0


def to_svg(frames: Sequence[TouchFrame], kit: tuple[Pad, ...], settings: Settings) -> str:
    """Return the text of a file."""
    player = Player(kit, settings)
    gestures = [gesture for frame in frames for gesture in player.process(frame)]
    hits = [each for each in gestures if isinstance(each, Hit)]
    animation = Animation.of(frames, WIDTH_MM, HEIGHT_MM)
    for pad in kit:
        animation.lines += _pad(animation, pad, [hit for hit in hits if hit.pad.name == pad.name])
    animation.lines += [_ring(animation, hit) for hit in hits]
    animation.lines += _bar(animation, [each for each in gestures if isinstance(each, Shape)])
    animation.fingers(frames, FINGER)
    return animation.text(BACKGROUND)


def _pad(animation: Animation, pad: Pad, hits: Sequence[Hit]) -> list[str]:
    left, far, right, near = pad.area
    x, y, colour = left * WIDTH_MM + 1.5, far * HEIGHT_MM + 1.5, rgb(pad.colour)
    width, height = (right - left) * WIDTH_MM - 3.0, (near - far) * HEIGHT_MM - 3.0
    area = f'x="{x:g}" y="{y:g}" width="{width:g}" height="{height:g}" rx="2"'
    points = [(animation.begin_us, 0.2)]
    for hit in hits:
        points += [(hit.time_us - 1000, 0.2), (hit.time_us, 0.2 + 0.8 * hit.level)]
        points.append((hit.time_us + GLOW_US, 0.2))
    glow = animation.moving("fill-opacity", _one_after_the_other(points))
    middle = f'x="{x + width / 2:g}" y="{y + height / 2:g}"'
    return [
        f'<rect {area} fill="{colour}" fill-opacity="0.2" stroke="{colour}" '
        f'stroke-width="0.6">{glow}</rect>',
        f'<text {middle} fill="{FINGER}" font-size="8" text-anchor="middle">{pad.name}</text>',
    ]


def _one_after_the_other(points: list[tuple[int, float]]) -> list[tuple[int, float]]:
    """A glow that has not ended when the next one begins is cut off."""
    chosen: list[tuple[int, float]] = []
    for point in points:
        while chosen and chosen[-1][0] > point[0]:
            chosen.pop()
        chosen.append(point)
    return chosen


def _ring(animation: Animation, hit: Hit) -> str:
    at, end = hit.time_us, hit.time_us + RING_US
    place = f'cx="{hit.u * WIDTH_MM:.1f}" cy="{hit.v * HEIGHT_MM:.1f}"'
    grown = 4.0 + GROWN_MM * hit.level
    fading = [(animation.begin_us, 0.0), (at - 1000, 0.0), (at, 1.0), (end, 0.0)]
    return (
        f'<circle {place} r="4" fill="none" stroke="#ffffff" stroke-width="1" opacity="0">'
        + animation.moving("r", [(at, 4.0), (end, grown)])
        + animation.moving("opacity", fading)
        + "</circle>"
    )


def _bar(animation: Animation, shapes: Sequence[Shape]) -> list[str]:
    """A bar at the left edge: low and deep, or high and sharp."""
    if not shapes:
        return []
    tall = changes((each.time_us, round(each.height * HEIGHT_MM)) for each in shapes)
    height = animation.moving("height", tall)
    y = animation.moving("y", [(at, HEIGHT_MM - each) for at, each in tall])
    return [
        '<linearGradient id="hand" gradientUnits="userSpaceOnUse" x1="0" x2="0" '
        f'y1="{HEIGHT_MM:g}" y2="0"><stop stop-color="{LOW}"/>'
        f'<stop offset="1" stop-color="{HIGH}"/></linearGradient>',
        f'<rect x="0" width="{BAR_MM:g}" fill="url(#hand)">{height}{y}</rect>',
    ]
