"""Pictures that move: valid times, and what the stream holds appears in its time."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import pytest

from halo_drums.animated import to_svg as drumming
from halo_drums.kit import KIT, Settings
from halo_paint.animated import to_svg as painting
from halo_paint.painter import Painter
from halo_type.animated import to_svg as typing
from halo_type.layout import load_layout
from halo_type.typist import Trial, Typist

SVG = "{http://www.w3.org/2000/svg}"
CLIENTS = Path(__file__).parents[3] / "clients"
FIRST_S, EACH_S, SHOWN_S = 1.0, 0.5, 1.0 + 2 * 0.5 + 0.1667 + 1.5
"""When the first touch begins, the next ones, and how long the picture of `stream` is."""


def stream(wire: Any) -> list[Any]:
    """Three touches of 5 frames, each 0.5 s, on the keys d, f and g."""
    frames = []
    for number in range(60):
        contacts, step = divmod(number - 15, 15)
        at = (110.0 + 16.0 * contacts + 0.5 * step, 94.0)
        touching = 0 <= contacts < 3 and step < 6
        events: dict[str, Any] = {}
        if 0 <= contacts < 3 and step == 0:
            events["downs"] = (wire.down(at=at, contacts=contacts + 1, ago_ms=0.0),)
        elif 0 <= contacts < 3 and step == 6:
            events["ups"] = (wire.up(at=at, contacts=contacts + 1),)
        finger = wire.finger(
            at=at, pressure=0.8 if touching else None, hover_mm=7.0, contacts=contacts + 1
        )
        other = wire.finger(2, hand=1, at=(40.0, 150.0), hover_mm=20.0 + number / 4, contacts=0)
        frames.append(wire.frame(number, [finger, other], **events))
    return frames


def of_typing(frames: Sequence[Any]) -> str:
    return typing(frames, Typist(load_layout("qwerty"), [Trial("t", 1, "dfg")]))


MAKERS: dict[str, Callable[[Sequence[Any]], str]] = {
    "drums": lambda frames: drumming(frames, KIT, Settings()),
    "paint": lambda frames: painting(frames, Painter(), 300.0, 200.0),
    "type": of_typing,
}


def parsed(text: str) -> ElementTree.Element:
    return ElementTree.fromstring(text)


def times_s(element: ElementTree.Element) -> list[float]:
    seconds = float(element.attrib["dur"].removesuffix("s"))
    return [float(each) * seconds for each in element.attrib["keyTimes"].split(";")]


@pytest.mark.parametrize("text", ["stream", "nothing", "readme"])
@pytest.mark.parametrize("client", MAKERS)
def test_a_browser_accepts_every_animation(client: str, text: str, wire: Any) -> None:
    """A browser ignores an animation with times that do not rise, or not as many values."""
    svg = parsed(
        (CLIENTS / client / "animated.svg").read_text("utf-8")
        if text == "readme"
        else MAKERS[client](stream(wire) if text == "stream" else [wire.frame(0)])
    )
    animations = list(svg.iter(f"{SVG}animate"))
    assert animations or text == "nothing"
    for each in animations:
        times = [float(part) for part in each.attrib["keyTimes"].split(";")]
        assert times[0] == 0.0 and times == sorted(times)
        assert times[-1] == 1.0 if "calcMode" not in each.attrib else times[-1] <= 1.0
        assert len(times) == len(each.attrib["values"].split(";"))
        assert each.attrib["repeatCount"] == "indefinite"


def test_a_pad_glows_with_each_hit(wire: Any) -> None:
    svg = parsed(MAKERS["drums"](stream(wire)))
    glows = [
        each
        for each in svg.iter(f"{SVG}animate")
        if each.attrib["attributeName"] == "fill-opacity" and "calcMode" not in each.attrib
    ]
    lit = [
        at
        for glow in glows
        for at, value in zip(times_s(glow), glow.attrib["values"].split(";"), strict=True)
        if float(value) > 0.2
    ]
    assert len(glows) == len(KIT)
    assert lit == pytest.approx([FIRST_S + n * EACH_S for n in range(3)], abs=0.02)
    rings = [each for each in svg.findall(f"{SVG}circle") if each.get("fill") == "none"]
    assert len(rings) == 3


def test_a_stroke_is_hidden_before_its_touch_and_complete_after_it(wire: Any) -> None:
    svg = parsed(MAKERS["paint"](stream(wire)))
    ways = list(svg.iter(f"{SVG}polyline"))
    assert len(ways) == 3
    for number, way in enumerate(ways):
        dash = float(way.attrib["stroke-dasharray"])
        width = float(way.attrib["stroke-width"])
        (uncover,) = way
        times, values = times_s(uncover), [float(v) for v in uncover.attrib["values"].split(";")]
        assert values[0] == pytest.approx(dash + width, abs=0.2)
        assert values[-1] == pytest.approx(dash - (dash - 3.0 * width), abs=0.2)
        assert values == sorted(values, reverse=True)
        begun = next(at for at, v in zip(times, values, strict=True) if v < dash)
        assert begun == pytest.approx(FIRST_S + number * EACH_S, abs=0.1)


def test_a_text_appears_key_by_key(wire: Any) -> None:
    svg = parsed(of_typing(stream(wire)))
    texts = {each.text: each for each in svg.iter(f"{SVG}text") if len(each)}
    for number, text in enumerate(("d", "df", "dfg")):
        (shown,) = texts[text]
        appears = dict(zip(shown.attrib["values"].split(";"), times_s(shown), strict=False))
        assert appears["1"] == pytest.approx(FIRST_S + number * EACH_S, abs=0.04)


def test_the_picture_begins_before_the_first_touch_and_ends_after_the_last(wire: Any) -> None:
    (any_one, *_) = parsed(MAKERS["drums"](stream(wire))).iter(f"{SVG}animate")
    assert float(any_one.attrib["dur"].removesuffix("s")) == pytest.approx(SHOWN_S, abs=0.05)
