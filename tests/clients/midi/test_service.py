"""A service that is lost or restarts, and Ctrl-C: no note goes on."""

from __future__ import annotations

from typing import Any

import mido
import pytest

from halo_client import Receiver
from halo_midi.layouts import board
from halo_midi.player import Player
from halo_protocol import Frame, TouchFrame, encode_frame
from tests.clients.midi.mpe import Receiver as Synthesiser


class Source:
    """Datagrams that a test puts in."""

    url = "test://"

    def __init__(self) -> None:
        self.waiting: list[bytes] = []

    def receive(self, timeout_s: float) -> tuple[bytes, str] | None:
        return (self.waiting.pop(0), "test") if self.waiting else None

    def close(self) -> None:
        """Nothing is open."""


class Rig:
    """A receiver, a player and a synthesiser, with a clock of their own."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self.now_s = 100.0
        monkeypatch.setattr("halo_client.receiver.time.monotonic", lambda: self.now_s)
        self.source, self.player = Source(), Player(board("grid"))
        self.receiver = Receiver(self.source)
        self.sent: list[mido.Message] = self.player.opening()

    def send(self, session: str, number: int, pointers: list[Any], downs: list[Any]) -> None:
        header = Frame("desk", session, number, *divmod(number * 33_333, 10**6), len(pointers))
        self.source.waiting += encode_frame("table", header, pointers, downs, [])
        while self.source.waiting:
            self.poll()

    def poll(self) -> None:
        for event in self.receiver.poll(0.0):
            if isinstance(event, TouchFrame):
                self.sent += [each.message for each in self.player.process(event)]

    def notes(self) -> list[str]:
        return [each.type for each in self.sent if each.type in ("note_on", "note_off")]

    def broken(self) -> list[str]:
        synthesiser = Synthesiser()
        for message in self.sent:
            synthesiser.read(message.bytes())
        return synthesiser.end()


@pytest.fixture
def rig(monkeypatch: pytest.MonkeyPatch, wire: Any) -> Rig:
    """Two fingers sound."""
    started = Rig(monkeypatch)
    fingers = [wire.finger(1, pressure=0.5), wire.finger(2, at=(30.0, 30.0), pressure=0.5)]
    # A client that joins gets only touches that begin after its first frame.
    hovering = [wire.finger(1, hover_mm=9.0, contacts=0), wire.finger(2, hover_mm=9.0, contacts=0)]
    started.send("s1", 1, hovering, [])
    started.send("s1", 2, fingers, [wire.down(1), wire.down(2, at=(30.0, 30.0))])
    assert started.notes() == ["note_on"] * 2
    return started


def test_a_lost_service_ends_all_notes(rig: Rig) -> None:
    rig.now_s += 1.0
    rig.poll()
    assert rig.notes() == ["note_on"] * 2, "a second of silence is no loss"
    rig.now_s += 4.0
    rig.poll()
    assert rig.notes() == ["note_on"] * 2 + ["note_off"] * 2
    assert rig.broken() == []


def test_a_restarted_service_ends_all_notes(rig: Rig, wire: Any) -> None:
    rig.now_s += 0.5
    rig.send("s2", 1, [wire.finger(1, pressure=0.5)], [])
    assert rig.notes() == ["note_on"] * 2 + ["note_off"] * 2
    assert rig.broken() == []


def test_ctrl_c_ends_all_notes(rig: Rig) -> None:
    rig.sent += rig.player.closing()
    assert rig.notes() == ["note_on"] * 2 + ["note_off"] * 2
    assert rig.broken() == []
