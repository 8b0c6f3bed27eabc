"""A port that vanishes comes back with its zone; a port of one's own is created and removed.

This machine may have no ALSA sequencer: the ports are substitutes at mido's functions. Where the
kernel has one, the last test uses it.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import mido
import pytest

from halo_midi.errors import MidiError
from halo_midi.layouts import board
from halo_midi.player import Player
from halo_midi.port import MidiPort, OwnPort
from tests.clients.midi.mpe import Receiver


class Port:
    def __init__(self) -> None:
        self.sent: list[list[int]] = []
        self.dead = self.closed = False

    def send(self, message: mido.Message) -> None:
        if self.dead:
            raise OSError("the port was closed")
        self.sent.append(message.bytes())

    def close(self) -> None:
        self.closed = True


class Ports:
    """MIDI ports that come and go."""

    def __init__(self, *names: str) -> None:
        self.names = list(names)
        self.opened: list[Port] = []

    def get_output_names(self) -> list[str]:
        return list(self.names)

    def open_output(self, name: str, *, virtual: bool = False) -> Port:
        self.opened.append(Port())
        return self.opened[-1]


def broken(port: Port) -> list[str]:
    receiver = Receiver()
    for message in port.sent:
        receiver.read(message)
    return receiver.end()


def wait_for(condition: Callable[[], bool]) -> None:
    until = time.monotonic() + 10.0
    while not condition():
        assert time.monotonic() < until
        time.sleep(0.005)


def play(output: MidiPort | OwnPort, player: Player, frame: Any) -> None:
    output.send(lambda: [each.message for each in player.process(frame)])


@pytest.mark.parametrize("reported", [True, False], ids=["send fails", "nothing reports it"])
def test_a_synthesiser_that_restarts_gets_zone_first_and_no_old_note(
    wire: Any, caplog: pytest.LogCaptureFixture, reported: bool
) -> None:
    ports, player = Ports("Surge XT 128:0"), Player(board("grid"))
    with MidiPort("surge", player.opening, player.closing, ports, look_s=0.01) as port:
        play(port, player, wire.frame(0, [wire.finger(pressure=0.5)], downs=(wire.down(),)))
        ports.names, ports.opened[0].dead = [], reported
        play(port, player, wire.frame(1, [wire.finger(pressure=0.9)]))
        wait_for(lambda: "is lost" in caplog.text)
        play(port, player, wire.frame(2, [wire.finger(pressure=0.5)]))
        ports.names = ["Surge XT 131:0"]
        wait_for(lambda: "is back" in caplog.text)
        play(port, player, wire.frame(3, [wire.finger(pressure=0.9)]))
        struck = wire.frame(4, [wire.finger(id=2, pressure=0.5)], downs=(wire.down(id=2),))
        play(port, player, struck)
    first, second = ports.opened
    assert first.closed and second.closed
    assert broken(second) == []
    assert sum(message[0] & 0xF0 == 0x90 for message in second.sent) == 1


def test_a_port_of_one_s_own_begins_with_the_zone_and_ends_in_silence(wire: Any) -> None:
    ports, player = Ports(), Player(board("grid"))
    with OwnPort("halo-midi", player.opening, player.closing, ports) as port:
        play(port, player, wire.frame(0, [wire.finger(pressure=0.5)], downs=(wire.down(),)))
    assert broken(ports.opened[0]) == []
    assert ports.opened[0].closed


def test_a_message_that_fails_ends_nothing(caplog: pytest.LogCaptureFixture) -> None:
    ports = Ports()
    with OwnPort("halo-midi", list, list, ports) as port:
        ports.opened[0].dead = True
        for _ in range(2):
            port.send(lambda: [mido.Message("note_on")])
    assert caplog.text.count("a message was not sent (the port was closed)") == 1


def test_an_unknown_port_is_refused_with_those_that_are_there() -> None:
    with pytest.raises(
        MidiError, match=r"no MIDI port is called 'moog'; available: Surge 1, Vital 2"
    ):
        MidiPort("moog", list, list, Ports("Surge 1", "Vital 2"))


def test_without_own_ports_there_is_one_sentence_with_the_remedy() -> None:
    class Windows(Ports):
        def open_output(self, name: str, *, virtual: bool = False) -> Port:
            raise NotImplementedError("virtual ports are not supported")

    with pytest.raises(MidiError, match=r"no MIDI port can be created .* loopMIDI.* --print"):
        OwnPort("halo-midi", list, list, Windows())


@pytest.mark.skipif(not Path("/dev/snd/seq").exists(), reason="no ALSA sequencer on this machine")
def test_alsa_s_sequencer_carries_the_notes(wire: Any) -> None:
    player = Player(board("grid"))
    with OwnPort("halo-midi-test", player.opening, player.closing) as port:
        name = next(each for each in mido.get_input_names() if "halo-midi-test" in each)
        with mido.open_input(name) as received:
            play(port, player, wire.frame(0, [wire.finger(pressure=0.5)], downs=(wire.down(),)))
            wait_for(lambda: any(each.type == "note_on" for each in received.iter_pending()))
