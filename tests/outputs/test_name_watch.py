"""Another service with the same node name is noticed."""

from __future__ import annotations

import logging
from collections.abc import Callable
from dataclasses import replace

import pytest

import halo_protocol as wire
from halo_service.outputs.name_watch import NameWatch

SCENE = wire.Scene("desk", "s2", "1.0.0", 300.0, 200.0, 2, 0, 0, 30.0)


@pytest.mark.parametrize(
    ("message", "collides"),
    [
        (SCENE, True),
        (replace(SCENE, session="s1"), False),
        (replace(SCENE, node="wall"), False),
        (wire.Health("desk", "s2", 30.0, 3.0, 0, 0, 3, 1), False),
    ],
)
def test_a_scene_of_our_name_and_another_session_collides(
    message: wire.Message, collides: bool
) -> None:
    watch = NameWatch("desk", "s1")
    watch.datagram(wire.encode("table", message), 10.0)
    assert watch.collision(10.1) is collides


def test_a_collision_ends_with_the_other_service() -> None:
    watch = NameWatch("desk", "s1")
    watch.datagram(wire.encode("table", SCENE), 10.0)
    assert watch.collision(14.0)
    assert not watch.collision(16.0)


def test_it_is_logged_once_per_session(caplog: pytest.LogCaptureFixture) -> None:
    watch = NameWatch("desk", "s1")
    with caplog.at_level(logging.WARNING):
        for n in range(20):
            watch.seen("desk", "s2" if n < 10 else "s3", float(n))
    assert [record.getMessage().count("also called 'desk'") for record in caplog.records] == [1, 1]


@pytest.mark.parametrize("make", [lambda: b"", lambda: b"nonsense", lambda: b"#bundle\0" * 9])
def test_bad_bytes_are_ignored(make: Callable[[], bytes]) -> None:
    watch = NameWatch("desk", "s1")
    watch.datagram(make(), 1.0)
    assert not watch.collision(1.0)
