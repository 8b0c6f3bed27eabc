"""A finger has a channel: the one that is free for the longest time, and stealing is last."""

from __future__ import annotations

from halo_midi.zone import Zone


def started(zone: Zone[str], *fingers: str) -> list[int]:
    return [zone.start(finger)[0] for finger in fingers]


def test_the_channel_that_was_released_first_is_used_first() -> None:
    zone: Zone[str] = Zone(3)
    assert started(zone, "a", "b", "c") == [1, 2, 3]
    for finger in ("b", "c", "a"):
        zone.end(finger)
    assert started(zone, "d", "e", "f") == [2, 3, 1]


def test_a_note_uses_the_channel_that_its_finger_reserved_in_the_air() -> None:
    zone: Zone[str] = Zone(3)
    assert [zone.reserve("a"), zone.reserve("b"), zone.reserve("a")] == [1, 2, 1]
    assert zone.hovering == ["a", "b"]
    assert started(zone, "b", "c", "a") == [2, 3, 1]
    assert zone.hovering == []


def test_a_finger_that_leaves_the_air_gives_its_channel_back_unused() -> None:
    zone: Zone[str] = Zone(2)
    zone.reserve("a")
    zone.cancel("a")
    zone.cancel("a")
    assert started(zone, "b", "c") == [1, 2]


def test_hovering_fingers_never_take_a_channel_from_a_note() -> None:
    zone: Zone[str] = Zone(2)
    started(zone, "a", "b")
    assert zone.reserve("c") is None
    zone.end("a")
    assert zone.reserve("c") == 1


def test_a_note_prefers_a_hovering_finger_s_channel_to_stealing() -> None:
    zone: Zone[str] = Zone(2)
    zone.reserve("a")
    started(zone, "b")
    assert zone.start("c") == (1, None)
    assert zone.hovering == []


def test_without_a_free_channel_the_oldest_note_is_stolen() -> None:
    zone: Zone[str] = Zone(2)
    started(zone, "a", "b")
    assert zone.start("c") == (1, "a")
    assert zone.start("d") == (2, "b")
    zone.end("a")  # its lift, later
    assert zone.start("e") == (1, "c")
