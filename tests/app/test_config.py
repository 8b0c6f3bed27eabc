"""Settings answer back."""

from __future__ import annotations

from dataclasses import fields
from pathlib import Path

import pytest

import halo_protocol as wire
from halo_service.app.config import Settings, default_node, load
from halo_service.errors import UserError
from halo_service.sensing import SensingSettings


def test_an_empty_file_is_the_defaults(tmp_path: Path) -> None:
    (tmp_path / "halo.toml").write_text("")
    assert load(tmp_path / "halo.toml") == Settings()


def test_what_is_set_is_set(tmp_path: Path) -> None:
    (tmp_path / "halo.toml").write_text(
        'node = "stage"\n[osc]\ndestinations = ["10.0.0.2:9000", "127.0.0.1:9000"]\n'
        "[sensing]\nhover_range_mm = 50\n[zenoh]\nenabled = false\n"
    )
    settings = load(tmp_path / "halo.toml")
    assert settings.node == "stage"
    assert settings.osc.destinations == ("10.0.0.2:9000", "127.0.0.1:9000")
    assert settings.sensing.hover_range_mm == 50.0
    assert not settings.zenoh.enabled


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("[osc]\nprot = 9000\n", "osc: unknown key 'prot'; known: enabled, destinations"),
        ("speed = 3\n", "unknown key 'speed'; known: node, profile, source"),
        ("[control]\nport = '9001'\n", "control: 'port' must be a whole number, not '9001'"),
        ("[osc]\ndestinations = '127.0.0.1:9000'\n", "osc: 'destinations' must be a list of text"),
        ("[sensing]\nhover_range_mm = true\n", "sensing: 'hover_range_mm' must be a number"),
        ("[sensing]\nfingers = 'thumb'\n", "sensing: 'fingers' must be index or all, not 'thumb'"),
        ("osc = 3\n", "'osc' must be a table"),
        ("[control]\nport = 0\n", "control: 'port' must be from 1 to 65535, not 0"),
        ("[control]\nport = 70000\n", "control: 'port' must be from 1 to 65535, not 70000"),
        ("[tracking]\nmax_hands = 0\n", "tracking: 'max_hands' must be from 1 to 4, not 0"),
        ("[tracking]\nmax_hands = 5\n", "tracking: 'max_hands' must be from 1 to 4, not 5"),
        ("node = \n", "cannot be read"),
    ],
)
def test_what_is_wrong_is_said_with_what_is_known(tmp_path: Path, text: str, says: str) -> None:
    (tmp_path / "halo.toml").write_text(text)
    with pytest.raises(UserError) as error:
        load(tmp_path / "halo.toml")
    assert says in str(error.value)


NUMBERS = [each.name for each in fields(SensingSettings) if each.type == "float"]


@pytest.mark.parametrize("key", NUMBERS)
@pytest.mark.parametrize("number", ["-1", "-0.001", "nan", "inf", "-inf", "0"])
def test_no_number_of_the_sensing_can_break_it(tmp_path: Path, key: str, number: str) -> None:
    (tmp_path / "halo.toml").write_text(f"[sensing]\n{key} = {number}\n")
    if (key, number) == ("halo_threshold_mm", "0"):  # what the calibration measured
        assert load(tmp_path / "halo.toml").sensing.halo_threshold_mm == 0.0
        return
    with pytest.raises(UserError, match=f"sensing: '{key}' must be .*(more|finite).* not {number}"):
        load(tmp_path / "halo.toml")


def test_a_file_that_is_not_there_is_said(tmp_path: Path) -> None:
    with pytest.raises(UserError, match="cannot be read"):
        load(tmp_path / "none.toml")


def test_this_machines_name_is_a_node() -> None:
    assert wire.check_name(default_node(), "node")
