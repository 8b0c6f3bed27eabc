"""Which values can be sent, and how many."""

import math
from dataclasses import replace
from itertools import pairwise
from typing import Any

import pytest

from halo_protocol import (
    MAX_BUNDLE,
    MAX_EVENTS,
    Alive,
    Down,
    Frame,
    Health,
    Homography,
    Message,
    Pointer,
    Pose,
    ProtocolError,
    Scene,
    Up,
    decode,
    encode,
    encode_frame,
)
from halo_protocol.osc import IMMEDIATELY

HEADER = Frame("desk", "s1", 5, 1_700_000_000, 0, 0)
POINTER = Pointer(1, 0, 2, 1, 0, 0.5, 0.5, 150.0, 100.0, 3.0, 0.0, 0.0, 0.0, 1.0, 0, -1.0)
TAG = bytes.fromhex("e8fe6f8000000000")
"""The time of `HEADER` as NTP."""
DOWN = Down(1, 0, 0.5, 0.5, 100.0, 10.0, 1)
UP = Up(1, 0, 0.5, 0.5, 10.0, 1)
SCENE = Scene("desk", "s1", "1.0.0", 300.0, 200.0, 2, 0, 0, 30.0)
HOMOGRAPHY = Homography("desk", "s1", 0, 1920, 1080, (1.0,) * 9)
POSE = Pose("desk", "s1", 0, (1.0,) * 12, (0.0,) * 12, 0)
HEALTH = Health("desk", "s1", 30.0, 3.0, 0, 0, 3, 1)

UNSENDABLE = [
    ("nan", POINTER, {"u": math.nan}),
    ("infinity", POINTER, {"force_g": math.inf}),
    ("too large for a float32", POINTER, {"x_mm": 1e39}),
    ("too large for an int32", POINTER, {"contacts": 2**31}),
    ("a float for an int", POINTER, {"slot": 0.5}),
    ("a negative id", POINTER, {"id": -1}),
    ("a negative slot", DOWN, {"slot": -1}),
    ("a negative number of contacts", UP, {"contacts": -1}),
    ("a node with a slash", HEALTH, {"node": "a/b"}),
    ("a node with a zero byte", HEALTH, {"node": "a\0"}),
    ("a node with a line's end", HEALTH, {"node": "desk\n"}),
    ("a session in capitals", SCENE, {"session": "S1"}),
    ("a version of two numbers", SCENE, {"version": "1.0"}),
    ("a surface without size", SCENE, {"width_mm": 0.0}),
    ("a projector without pixels", HOMOGRAPHY, {"height_px": 0}),
    ("a matrix of eight", HOMOGRAPHY, {"projector_from_surface": (1.0,) * 8}),
    ("a matrix with nan", POSE, {"camera_from_surface": (math.nan,) * 12}),
    ("half an anchor", POSE, {"anchored": 2}),
    ("a frame number too large", HEADER, {"frame": 2**24}),
    ("a time after 2038", HEADER, {"time_s": 2**31}),
    ("a session time too large", HEADER, {"session_ms": 2**24}),
    ("a session like a number", HEADER, {"session": "1e205678"}),
    ("half a collision", SCENE, {"collision": 2}),
    ("a calibration before time", SCENE, {"calibrated_s": -1}),
    ("a control port that does not exist", SCENE, {"control_port": 65_536}),
    ("a million microseconds", HEADER, {"time_frac_us": 1_000_000}),
    ("a million microseconds in health", HEALTH, {"time_frac_us": 1_000_000}),
    ("a version with a control character", SCENE, {"service_version": "1.0\x1b[2J"}),
    ("a version of 33 characters", SCENE, {"zenoh_version": "1" * 33}),
]


@pytest.mark.parametrize(("what", "message", "changes"), UNSENDABLE, ids=[u[0] for u in UNSENDABLE])
def test_an_unreadable_value_is_not_sent(
    what: str, message: Message, changes: dict[str, Any]
) -> None:
    encode("table", message)
    with pytest.raises(ProtocolError):
        encode("table", replace(message, **changes))


@pytest.mark.parametrize(
    "surface", ["control", "sim", "", "Table", "a/b", "*", "x" * 33, "tisch-ä"]
)
def test_an_invalid_surface_is_refused(surface: str) -> None:
    with pytest.raises(ProtocolError):
        encode(surface, SCENE)


def test_count_is_the_number_of_pointers() -> None:
    with pytest.raises(ProtocolError, match="count is 0, but there are 1 pointers"):
        encode_frame("table", HEADER, [POINTER])


def test_an_id_is_alive_once() -> None:
    with pytest.raises(ProtocolError, match="twice"):
        encode_frame("table", replace(HEADER, count=2), [POINTER, POINTER])


def test_more_than_64_pointers_are_refused_and_not_cut_off() -> None:
    pointers = [replace(POINTER, id=i) for i in range(65)]
    with pytest.raises(ProtocolError, match="64"):
        encode_frame("table", replace(HEADER, count=65), pointers)


def test_more_than_256_events_are_refused_and_not_cut_off() -> None:
    with pytest.raises(ProtocolError, match="256"):
        encode_frame("table", HEADER, [], [DOWN] * MAX_EVENTS, [UP])


@pytest.mark.parametrize("events", [0, 7, MAX_EVENTS // 2])
@pytest.mark.parametrize("count", [0, 1, 10, 11, 12, 64])
@pytest.mark.parametrize("name", ["s", "table", "x" * 32])
@pytest.mark.parametrize("max_bytes", [768, MAX_BUNDLE, 1432, 8000])
def test_a_frame_of_any_size_is_split_and_whole(
    max_bytes: int, name: str, count: int, events: int
) -> None:
    pointers = [replace(POINTER, id=i, slot=i) for i in range(count)]
    header = replace(HEADER, node=name, session=name, count=count)
    downs = [replace(DOWN, id=i) for i in range(events)]
    ups = [replace(UP, id=i) for i in range(events)]
    datagrams = encode_frame(name, header, pointers, downs, ups, max_bytes=max_bytes)
    assert max(map(len, datagrams)) <= max_bytes
    parts = [[message for _, message in decode(datagram)] for datagram in datagrams]
    assert all(part[0] == header for part in parts)
    assert all(part[-1] == Alive(tuple(range(count))) for part in parts)
    assert [message for part in parts for message in part[1:-1]] == [*downs, *ups, *pointers]
    for datagram, following in pairwise(zip(datagrams, parts, strict=True)):
        first = following[1][1]
        assert len(datagram[0]) + len(encode(name, first)) - 16 > max_bytes, "room was left"


def test_ten_fingers_pass_a_tunnel_in_two_bundles() -> None:
    pointers = [replace(POINTER, id=i, slot=i) for i in range(10)]
    sizes = list(map(len, encode_frame("table", replace(HEADER, count=10), pointers)))
    assert len(sizes) == 2
    assert max(sizes) <= 1280 - 40 - 8, "IPv6's smallest packet minus its headers"


def test_a_bundle_too_small_for_a_pointer_is_refused() -> None:
    with pytest.raises(ProtocolError, match="200 bytes is too small"):
        encode_frame("table", replace(HEADER, count=1), [POINTER], max_bytes=200)


@pytest.mark.parametrize(("timetagged", "timetag"), [(False, IMMEDIATELY), (True, TAG)])
def test_a_frame_is_for_immediately_unless_timetagged(timetagged: bool, timetag: bytes) -> None:
    (datagram,) = encode_frame("table", HEADER, [], timetagged=timetagged)
    assert datagram[8:16] == timetag


@pytest.mark.parametrize(
    ("time_us", "timetag"),
    [
        (0, "83aa7e8000000000"),  # 1970, by RFC 5905
        (1_700_000_000_500_000, "e8fe6f8080000000"),
        (2_085_978_496_000_000, "0000000000000000"),  # NTP's era 1 begins in 2036
    ],
)
def test_the_timetag_is_the_time_as_ntp(time_us: int, timetag: str) -> None:
    assert encode("table", SCENE, time_us)[8:16].hex() == timetag


def test_without_a_time_the_timetag_is_immediately() -> None:
    assert encode("table", SCENE)[8:16] == bytes(7) + b"\x01"
