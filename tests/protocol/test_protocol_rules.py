"""Names, keys, counters and versions."""

import pytest

from halo_protocol import (
    ANY,
    VERSION,
    ProtocolError,
    address,
    check_name,
    check_surface,
    first_frame,
    is_newer,
    liveliness_key,
    next_frame,
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


TOP = 2**31 - 1


@pytest.mark.parametrize(
    ("a", "b", "newer"),
    [
        (1, 0, True),
        (0, 1, False),
        (5, 5, False),
        (0, TOP, True),
        (TOP, 0, False),
        (2**30 - 1, 0, True),
        (2**30, 0, False),
        (2**30 - 2, TOP, True),
        (10, TOP - 10, True),
    ],
)
def test_newer_is_modular(a: int, b: int, newer: bool) -> None:
    assert is_newer(a, b) is newer


def test_the_counter_wraps() -> None:
    assert next_frame(TOP) == 0
    assert next_frame(0) == 1


@pytest.mark.parametrize("rate_hz", [5, 30, 100])
@pytest.mark.parametrize("ran_s", [1, 3600, 30 * 86400])
def test_a_restart_is_newer_than_all_that_was_sent(rate_hz: int, ran_s: int) -> None:
    started_us = 1_700_000_000_000_000
    last = (first_frame(started_us) + rate_hz * ran_s - 1) % 2**31
    again = first_frame(started_us + ran_s * 1_000_000)
    assert is_newer(again, last)


def test_the_seed_is_unix_time_in_hundredths() -> None:
    assert first_frame(1_700_000_000_129_999) == 170_000_000_012 % 2**31


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
