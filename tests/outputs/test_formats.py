"""`flat`, `tuio11` and `tuio2`, read by python-osc."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest
from pythonosc.osc_bundle import OscBundle
from pythonosc.osc_message import OscMessage

import halo_protocol as wire
from halo_service.outputs.formats.flat import FlatFormat
from halo_service.outputs.formats.tuio2 import Tuio2Format
from halo_service.outputs.formats.tuio11 import Tuio11Format
from tests.outputs.samples import HOVERING, TOUCHING, fingers, frame

DOWN = wire.Down(7, 0, 0.5, 0.25, 210.0, 5.0, 3)


def read(datagrams: list[bytes]) -> list[list[tuple[str, list[Any]]]]:
    """The messages of each bundle, by python-osc."""
    return [[(each.address, list(each.params)) for each in OscBundle(raw)] for raw in datagrams]


def values(datagrams: list[bytes]) -> dict[str, Any]:
    """Address -> the one number there."""
    return {
        address: number for part in read(datagrams) for address, (number,) in part
    }  # a message with another count of numbers fails here


def test_flat_has_one_number_per_address() -> None:
    found = values(FlatFormat().frame(frame(1, (TOUCHING,), (DOWN,))))
    slot = {
        address.rpartition("/")[2]: number
        for address, number in found.items()
        if "/slot/0/" in address
    }
    assert slot == pytest.approx(
        {
            "u": 0.5, "v": 0.25, "x_mm": 150.0, "y_mm": 50.0, "hover": 0.0, "pressure": 0.5,
            "touch": 1, "force_g": 80.0, "vx": 30.0, "vy": -20.0, "strike": 210.0, "id": 7,
        }
    )  # fmt: skip
    assert found["/halo/1/table/count"] == 1


def test_a_slot_without_a_finger_is_gone_in_every_frame() -> None:
    flat = FlatFormat()
    flat.frame(frame(1, (TOUCHING,)))
    for n in range(2, 5):
        found = values(flat.frame(frame(n)))
        assert found["/halo/1/table/count"] == 0
        for slot in range(10):
            assert found[f"/halo/1/table/slot/{slot}/touch"] == 0
            assert found[f"/halo/1/table/slot/{slot}/hover"] == -1.0


def test_only_changes_are_sent_and_all_once_a_second() -> None:
    flat = FlatFormat(changes=True)
    counts = [len(values(flat.frame(frame(n, (TOUCHING,))))) for n in range(61)]
    assert counts[0] == 12 + 9 * 2 + 1
    assert counts[1:30] == [0] * 29
    assert counts.count(counts[0]) == 2, "frames 0 and 31 (1.03 s)"
    moved = values(flat.frame(frame(61, (replace(TOUCHING, pressure=0.75),))))
    assert list(moved) == ["/halo/1/table/slot/0/pressure"]


def test_without_bundles_each_message_is_a_datagram() -> None:
    datagrams = FlatFormat(bundles=False).frame(frame(1, (TOUCHING,)))
    assert {len(OscMessage(raw).params) for raw in datagrams} == {1}
    assert len(datagrams) == 12 + 9 * 2 + 1


def test_tuio11_has_touching_cursors_in_2d_and_all_with_height_in_25d() -> None:
    hovering = replace(HOVERING, id=8, slot=1, hover_mm=25.0)
    flat, tall = read(Tuio11Format().frame(frame(1, (TOUCHING, hovering))))
    (_, source), (_, alive), (_, cursor), (_, fseq) = flat
    assert {address for address, _ in flat} == {"/tuio/2Dcur"}
    assert source == ["source", "halo@desk"]
    assert cursor == pytest.approx(["set", alive[1], 0.5, 0.25, 0.1, -0.1, 0.0])
    assert alive[0] == "alive" and len(alive) == 2
    assert fseq[0] == "fseq" and fseq[1] > 0
    (_, _), (_, alive), (_, touch), (_, hover), (_, _) = tall
    assert {address for address, _ in tall} == {"/tuio/25Dcur"}
    assert alive[2] - alive[1] == 1
    assert touch[2:5] == pytest.approx([0.5, 0.25, 0.0])
    assert hover[2:5] == pytest.approx([0.5, 0.25, 0.25])


def test_tuio2_press_is_pressure_or_minus_the_height() -> None:
    hovering = replace(HOVERING, id=8, slot=1, hover_mm=25.0, hand=1, finger=0)
    ((frm, touch, hover, alive),) = read(Tuio2Format().frame(frame(1, (TOUCHING, hovering))))
    assert (frm[0], touch[0], alive[0]) == ("/tuio2/frm", "/tuio2/ptr", "/tuio2/alv")
    assert frm[1][2:] == [300 << 16 | 200, "halo@desk"]
    assert alive[1] == [touch[1][0], hover[1][0]]
    assert touch[1][1:] == pytest.approx([1, 0, 0.5, 0.25, 0, 0, 0, 0.5, 0.1, -0.1, 0, 0, 0])
    assert hover[1][1:3] == [10, 1], "the left thumb, slot 1"
    assert hover[1][8] == pytest.approx(-0.25)


@pytest.mark.parametrize("make", [Tuio11Format, Tuio2Format])
@pytest.mark.parametrize("count", [0, 1, 10, 30, 64])
def test_tuio_is_split_with_growing_numbers_and_the_full_alive_list(make: Any, count: int) -> None:
    tuio = make()
    parts = read(tuio.frame(frame(1, fingers(count)))) + read(tuio.frame(frame(2, fingers(count))))
    numbers = [number(part) for part in parts]
    assert numbers == sorted(set(numbers))
    for part in parts:
        if part[0][0] == "/tuio/25Dcur":
            assert len(part[1][1]) == 1 + count
        if part[0][0] == "/tuio2/frm":
            assert len(part[-1][1]) == count


def number(part: list[tuple[str, list[Any]]]) -> int:
    address, arguments = part[0] if part[0][0] == "/tuio2/frm" else part[-1]
    return int(arguments[0 if address == "/tuio2/frm" else 1])


@pytest.mark.parametrize("make", [Tuio11Format, Tuio2Format])
def test_a_restarted_service_is_ahead_of_what_it_sent(make: Any) -> None:
    before = make()
    last = [number(read(before.frame(frame(n, fingers(3))))[-1]) for n in range(300)][-1]
    again = make().frame(frame(330, fingers(3)))
    assert number(read(again)[0]) > last


@pytest.mark.parametrize("make", [Tuio11Format, Tuio2Format])
def test_positions_outside_the_surface_are_clamped(make: Any) -> None:
    outside = replace(TOUCHING, u=-0.1, v=1.05)
    cursor = next(
        arguments
        for address, arguments in read(make().frame(frame(1, (outside,))))[0]
        if address == "/tuio2/ptr" or "set" in arguments
    )
    at = 3 if make is Tuio2Format else 2
    assert cursor[at : at + 2] == [0.0, 1.0]
