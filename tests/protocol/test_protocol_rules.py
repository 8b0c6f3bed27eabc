"""Names, keys, counters and versions."""

import struct

import pytest

from halo_protocol import (
    ANY,
    VERSION,
    ProtocolError,
    address,
    check_name,
    check_session,
    check_surface,
    first_frame,
    is_newer,
    liveliness_key,
    next_frame,
    session_ms,
    verdict,
    zenoh_key,
)


@pytest.mark.parametrize("name", ["a", "desk", "table_2", "x" * 32, "0-9"])
def test_good_names_pass(name: str) -> None:
    assert check_name(name, "node") == check_surface(name) == name


@pytest.mark.parametrize(
    "name", ["", "x" * 33, "Desk", "a b", "a/b", "*", "$", "@v1", "ä", "a\n", "٣"]
)
def test_bad_names_are_refused(name: str) -> None:
    with pytest.raises(ProtocolError, match="node must be"):
        check_name(name, "node")


@pytest.mark.parametrize("name", ["control", "sim"])
def test_reserved_surfaces_are_refused(name: str) -> None:
    with pytest.raises(ProtocolError, match="reserved"):
        check_surface(name)


def test_addresses_and_keys_are_as_specified() -> None:
    assert address("table", "pointer") == "/halo/1/table/pointer"
    assert zenoh_key("desk", "table", "frame") == "halo/1/desk/table/frame"
    assert zenoh_key(ANY, ANY, ANY) == "halo/1/*/*/*"
    assert liveliness_key("desk") == "halo/1/desk/alive"
    assert liveliness_key(ANY) == "halo/1/*/alive"


@pytest.mark.parametrize(
    "parts", [("*", "**", "frame"), ("a/b", "table", "frame"), ("a", "b", "x")]
)
def test_an_invalid_part_of_a_key_is_refused(parts: tuple[str, str, str]) -> None:
    with pytest.raises(ProtocolError):
        zenoh_key(*parts)


@pytest.mark.parametrize("name", ["s1", "replay-3f2a", "g", "z" * 32, "n1e5"])
def test_good_sessions_pass(name: str) -> None:
    assert check_session(name) == name


@pytest.mark.parametrize(
    "name", ["1e205678", "12", "0x10", "e5", "-1", "_s", "dead", "", "S1", "s" * 33]
)
def test_a_session_that_a_tool_may_read_as_a_number_is_refused(name: str) -> None:
    with pytest.raises(ProtocolError, match="session must be"):
        check_session(name)


TOP = 2**24 - 1


@pytest.mark.parametrize(
    ("a", "b", "newer"),
    [
        (1, 0, True),
        (0, 1, False),
        (5, 5, False),
        (0, TOP, True),
        (TOP, 0, False),
        (2**23 - 1, 0, True),
        (2**23, 0, False),
        (2**23 - 2, TOP, True),
        (10, TOP - 10, True),
    ],
)
def test_newer_is_modular(a: int, b: int, newer: bool) -> None:
    assert is_newer(a, b) is newer


def test_the_counter_wraps() -> None:
    assert next_frame(TOP) == 0
    assert next_frame(0) == 1


def test_every_number_is_exact_in_a_float32() -> None:
    for number in (TOP, first_frame(1_700_000_000_123_456), session_ms(10**15, 1)):
        assert struct.unpack(">f", struct.pack(">f", number)) == (number,)
    assert struct.unpack(">f", struct.pack(">f", 2**24 + 1)) != (2**24 + 1,)


class WithoutSessions:
    """A client that keeps no session, with the rule of SPEC.md."""

    def __init__(self) -> None:
        self.last: int | None = None
        self.accepted_s = 0.0

    def accepts(self, frame: int, now_s: float) -> bool:
        newer = self.last is None or is_newer(frame, self.last)
        if newer or now_s - self.accepted_s > 1.0:
            self.last, self.accepted_s = frame, now_s
            return True
        return False


@pytest.mark.parametrize("rate_hz", [5, 30, 100])
@pytest.mark.parametrize("ran_s", [1, 3600, 86_400, 2 * 86_400, 30 * 86_400])
def test_a_client_without_sessions_follows_a_restart_within_a_second(
    rate_hz: int, ran_s: int
) -> None:
    started_us = 1_700_000_000_000_000
    client = WithoutSessions()
    last = (first_frame(started_us) + rate_hz * ran_s - 1) % 2**24
    again = first_frame(started_us + ran_s * 1_000_000)
    assert client.accepts(last, 0.0)
    frames = [(again + n) % 2**24 for n in range(2 * rate_hz)]
    accepted = [client.accepts(frame, 0.1 + n / rate_hz) for n, frame in enumerate(frames)]
    assert all(accepted[rate_hz + 1 :])
    # At 30 frames a second the counter alone shows a restart for 33 hours.
    if rate_hz == 30 and ran_s <= 33 * 3600:
        assert accepted[0]


def test_datagrams_out_of_order_do_not_look_like_a_restart() -> None:
    client = WithoutSessions()
    order = [0, 2, 1, 3, 5, 4, 6]
    assert [client.accepts(n, i / 30) for i, n in enumerate(order)] == [
        n == max(order[: i + 1]) for i, n in enumerate(order)
    ]


def test_the_session_time_wraps() -> None:
    assert session_ms(5_000_999, 5_000_000) == 0
    assert session_ms(5_001_000, 5_000_000) == 1
    assert session_ms(2**24 * 1000 + 7000, 0) == 7


def test_the_seed_is_unix_time_in_hundredths() -> None:
    assert first_frame(1_700_000_000_129_999) == 170_000_000_012 % 2**24


@pytest.mark.parametrize(
    ("service", "client", "outcome"),
    [
        ("1.0.0", "1.0.0", "accepted"),
        ("1.0.7", "1.0.0", "accepted"),
        ("1.0.0", "1.0.7", "accepted"),
        ("1.2.0", "1.1.9", "warned"),
        ("1.2.0", "1.3.0", "refused"),
        ("1.2.0", "2.2.0", "refused"),
        ("2.0.0", "1.9.0", "refused"),
        ("1.10.0", "1.9.0", "warned"),
        (VERSION, VERSION, "accepted"),
    ],
)
def test_the_outcome_of_two_versions(service: str, client: str, outcome: str) -> None:
    assert verdict(service, client) == outcome


@pytest.mark.parametrize(
    "version", ["", "1", "1.0", "1.0.0.0", "1.0.x", "-1.0.0", "1.0.0\n", "9" * 99]
)
def test_a_version_is_three_numbers(version: str) -> None:
    with pytest.raises(ProtocolError):
        verdict(VERSION, version)
