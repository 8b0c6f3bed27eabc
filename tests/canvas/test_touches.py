"""Each touch is counted once, whoever sees it and in whatever order the reports arrive."""

from __future__ import annotations

import pytest

from halo_service.canvas.detections import NodeEvent
from halo_service.canvas.touches import MergedTouches

A = (("left", "table"), 1)
B = (("right", "table"), 1)
HOVERED, DISCOVERED = False, True

# (who, what, time in ms); "join": its pointer touched when it was seen first.
Step = tuple[object, str, int]
CASES: dict[str, tuple[list[Step], str]] = {
    "one node": ([(A, "down", 0), (A, "up", 100)], "down 0, up 100"),
    "both, a frame apart": (
        [(A, "down", 0), (B, "down", 33), (A, "up", 100), (B, "up", 133)],
        "down 0, up 133",
    ),
    "the later report comes first": (
        [(B, "down", 33), (A, "down", 0), (B, "up", 133), (A, "up", 100)],
        "down 33, up 100",
    ),
    "the second report comes after the end": (
        [(A, "down", 0), (A, "up", 50), (B, "down", 66), (B, "up", 110)],
        "down 0, up 50",
    ),
    "what seemed a late report goes on": (
        [(A, "down", 0), (A, "up", 20), (B, "down", 40), (None, "settle", 150), (B, "up", 900)],
        "down 0, up 20, down 40, up 900",
    ),
    "a slide over the seam": (
        [(A, "down", 0), (B, "join", 500), (A, "vanish", 600), (B, "up", 900)],
        "down 0, up 900",
    ),
    "a slide over the seam, the first node sees it lifted too early": (
        [(A, "down", 0), (B, "join", 500), (A, "up", 500), (B, "up", 900)],
        "down 0, up 900",
    ),
    "a slide over a gap": (
        [
            (A, "down", 0), (A, "vanish", 500), (None, "settle", 600),
            (B, "join", 610), (B, "up", 900),
        ],
        "down 0, up 900",
    ),
    "a finger that vanishes at the seam and does not return": (
        [(A, "down", 0), (A, "vanish", 500), (None, "settle", 660)],
        "down 0, up 500",
    ),
    "one node sees it lifted, then another one loses it": (
        [(A, "down", 0), (B, "down", 20), (A, "up", 60), (B, "vanish", 70), (A, "down", 190)],
        "down 0, up 70, down 190",
    ),
    "two taps, both nodes": (
        [
            (A, "down", 0), (B, "down", 30), (A, "up", 60), (B, "up", 90),
            (A, "down", 130), (B, "down", 160), (A, "up", 190), (B, "up", 220),
        ],
        "down 0, up 90, down 130, up 220",
    ),
    "two taps, each node sees another one": (
        [(A, "down", 0), (A, "up", 60), (B, "down", 130), (B, "up", 190)],
        "down 0, up 60, down 130, up 190",
    ),
    "two taps, the up of the first is late": (
        [(A, "down", 0), (B, "down", 130), (A, "up", 120), (B, "up", 190)],
        "down 0, up 120, down 130, up 190",
    ),
    "two taps, one node is late": (
        [
            (A, "down", 0), (B, "down", 50), (A, "up", 60), (A, "down", 130),
            (B, "up", 110), (B, "down", 180), (A, "up", 190), (B, "up", 240),
        ],
        "down 0, up 110, down 130, up 240",
    ),
    "a release that may be none, and is none": (
        [(A, "down", 0), (A, "unsure up", 500), (B, "join", 560), (B, "up", 900)],
        "down 0, up 900",
    ),
    "a release that may be none, and is one": (
        [(A, "down", 0), (A, "unsure up", 100), (A, "down", 200), (A, "up", 260)],
        "down 0, up 100, down 200, up 260",
    ),
    "one of two nodes flickers": (
        [
            (A, "down", 0), (B, "down", 10), (B, "up", 300), (B, "down", 340),
            (A, "up", 800), (B, "up", 810),
        ],
        "down 0, up 810",
    ),
}  # fmt: skip


@pytest.mark.parametrize(("steps", "expected"), CASES.values(), ids=CASES)
def test_each_touch_is_counted_once(steps: list[Step], expected: str) -> None:
    touches = MergedTouches()
    changes = []
    for who, what, ms in steps:
        event = NodeEvent(ms * 1000, (0.0, 0.0))
        if what in ("down", "join"):
            changes += touches.down(who, event, discovered=what == "join")  # type: ignore[arg-type]
        elif what == "settle":
            changes += touches.decide(ms * 1000)
        else:
            returns = what in ("vanish", "unsure up")
            changes += touches.up(who, event, vanished=what == "vanish", returns=returns)  # type: ignore[arg-type]
    assert ", ".join(f"{each.kind} {each.event.time_us // 1000}" for each in changes) == expected
    downs = [each.number for each in changes if each.kind == "down"]
    assert downs == list(range(1, len(downs) + 1))
    ups = [each.number for each in changes if each.kind == "up"]
    assert ups == downs[: len(ups)]


def test_a_lost_node_ends_only_what_it_held_alone() -> None:
    touches = MergedTouches()
    touches.down(A, NodeEvent(0, (0.0, 0.0)), discovered=HOVERED)
    touches.down(B, NodeEvent(10, (0.0, 0.0)), discovered=DISCOVERED)
    assert touches.drop(A, NodeEvent(500, (0.0, 0.0))) == []
    assert [each.kind for each in touches.drop(B, NodeEvent(600, (0.0, 0.0)))] == ["up"]
