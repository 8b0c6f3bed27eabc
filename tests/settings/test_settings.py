"""Settings answer back."""

from __future__ import annotations

import json
from dataclasses import fields
from pathlib import Path

import pytest

import halo_protocol as wire
from halo_service.errors import UserError
from halo_service.sensing import SensingSettings
from halo_service.settings import Settings, default_node, load
from halo_service.settings.schema import FILE, schema_text


def test_an_empty_file_is_the_defaults(tmp_path: Path) -> None:
    (tmp_path / "halo.toml").write_text("")
    assert load(tmp_path / "halo.toml") == Settings()


def test_what_is_set_is_set(tmp_path: Path) -> None:
    (tmp_path / "halo.toml").write_text(
        'node = "stage"\n[osc]\ndestinations = ["10.0.0.2:4256", "127.0.0.1:4256"]\n'
        "[sensing]\nhover_range_mm = 50\n[zenoh]\nenabled = false\n"
    )
    settings = load(tmp_path / "halo.toml")
    assert settings.node == "stage"
    assert settings.osc.destinations == ("10.0.0.2:4256", "127.0.0.1:4256")
    assert settings.sensing.hover_range_mm == 50.0
    assert not settings.zenoh.enabled


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("[osc]\nprot = 9000\n", "osc: unknown key 'prot'; known: enabled, destinations"),
        ("speed = 3\n", "unknown key 'speed'; known: node, profile, source"),
        ("[control]\nport = '4257'\n", "control: 'port' must be a whole number, not '4257'"),
        ("[osc]\ndestinations = '127.0.0.1:4256'\n", "osc: 'destinations' must be a list of text"),
        ("[sensing]\nhover_range_mm = true\n", "sensing: 'hover_range_mm' must be a number"),
        ("[sensing]\nfingers = 'thumb'\n", "sensing: 'fingers' must be index or all, not 'thumb'"),
        ("osc = 3\n", "'osc' must be a table"),
        ("[control]\nport = 0\n", "control: 'port' must be from 1 to 65535, not 0"),
        ("[control]\nport = 70000\n", "control: 'port' must be from 1 to 65535, not 70000"),
        ("[tracking]\nmax_hands = 0\n", "tracking: 'max_hands' must be from 1 to 4, not 0"),
        ("[tracking]\nmax_hands = 5\n", "tracking: 'max_hands' must be from 1 to 4, not 5"),
        ("node = \n", "cannot be read"),
        ("[control]\nprot = 9000\n", "known: host, port, networks; did you mean 'port'?"),
        ("node = 'My Desk'\n", "'node' must be text that matches ^[a-z0-9_-]{1,32}$, not 'My"),
        ("node = 2026-01-01\n", "'node' must be text, not ['2026-01-01']"),
        ("[osc]\ndestinations = [9000]\n", "osc: 'destinations' must be a list of text, not 9000"),
        (
            "[sensing]\nup_level = 0.5\ndown_level = 0.3\n",
            "sensing: 'up_level' must be below 'down_level', not 0.5 and 0.3",
        ),
        ("[sensing]\nup_level = 0.5\n", "'up_level' must be below 'down_level', not 0.5 and 0.5"),
        ("[sensing]\ndown_level = 1\n", "sensing: 'down_level' must be from 0.01 to 0.99, not 1"),
        ("[sensing]\nsure_level = 0.8\n", "unknown key 'sure_level'"),
        (
            '[source]\nname = "recording:C:\\tables\\new.mkv"\n',
            "source: 'name' holds the control character '\\t'; write a path with backslashes in "
            "single quotes",
        ),
        ('[osc]\ndestinations = ["a\\n"]\n', "osc: 'destinations' holds the control character"),
        ('profile = "C:\\Users\\me"\n', "in single quotes"),
        ('profile = "C:\\profile"\n', "in single quotes"),
    ],
)
def test_what_is_wrong_is_said_with_what_is_known(tmp_path: Path, text: str, says: str) -> None:
    (tmp_path / "halo.toml").write_text(text)
    with pytest.raises(UserError) as error:
        load(tmp_path / "halo.toml")
    assert says in str(error.value)


def test_every_error_of_a_file_is_one_line(tmp_path: Path) -> None:
    (tmp_path / "halo.toml").write_text("speed = 3\n[control]\nport = 0\nprot = 1\n")
    with pytest.raises(UserError) as error:
        load(tmp_path / "halo.toml")
    lines = str(error.value).splitlines()
    assert len(lines) == 3
    assert all(line.startswith(f"{tmp_path / 'halo.toml'}: ") for line in lines)


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16"])
def test_a_file_by_a_windows_editor_is_read(tmp_path: Path, encoding: str) -> None:
    text = 'profile = "Werkbank-Süd"\r\n[source]\r\nloop = true\r\n'
    (tmp_path / "halo.toml").write_bytes(text.encode(encoding))
    settings = load(tmp_path / "halo.toml")
    assert (settings.profile, settings.source.loop) == ("Werkbank-Süd", True)


@pytest.mark.parametrize(
    ("encoding", "says"),
    [
        ("latin-1", "it is not UTF-8 text (byte 21); save it as UTF-8"),
        ("utf-16-le", "UTF-16 without a byte-order mark; save it as UTF-8"),
    ],
)
def test_another_encoding_is_named(tmp_path: Path, encoding: str, says: str) -> None:
    (tmp_path / "halo.toml").write_bytes('profile = "Werkbank-Süd"\n'.encode(encoding))
    with pytest.raises(UserError) as error:
        load(tmp_path / "halo.toml")
    assert says in str(error.value)


def test_the_schema_in_docs_is_up_to_date() -> None:
    remedy = "run python -m halo_service.settings.schema"
    assert json.loads(FILE.read_text(encoding="utf-8")) == json.loads(schema_text()), remedy


def test_the_schema_says_range_unit_and_purpose_of_every_number_of_the_sensing() -> None:
    numbers = json.loads(schema_text())["$defs"]["SensingSettings"]["properties"]
    for key in NUMBERS:
        assert numbers[key].keys() & {"minimum", "exclusiveMinimum"}, key
        assert numbers[key]["description"], key
    assert numbers["fast_mm_s"]["unit"] == "mm/s"
    assert numbers["lost_after_ms"]["unit"] == "ms"


NUMBERS = [each.name for each in fields(SensingSettings) if isinstance(each.default, float)]


@pytest.mark.parametrize("key", NUMBERS)
@pytest.mark.parametrize("number", ["-1", "-0.001", "nan", "inf", "-inf", "0"])
def test_no_number_of_the_sensing_can_break_it(tmp_path: Path, key: str, number: str) -> None:
    (tmp_path / "halo.toml").write_text(f"[sensing]\n{key} = {number}\n")
    if (key, number) == ("halo_threshold_mm", "0"):  # what the calibration measured
        assert load(tmp_path / "halo.toml").sensing.halo_threshold_mm == 0.0
        return
    with pytest.raises(
        UserError, match=f"sensing: '{key}' must be .*(more|finite|from).* not {number}"
    ):
        load(tmp_path / "halo.toml")


def test_a_file_that_is_not_there_is_said(tmp_path: Path) -> None:
    with pytest.raises(UserError, match="file not found; check the path"):
        load(tmp_path / "none.toml")


def test_this_machines_name_is_a_node() -> None:
    assert wire.check_name(default_node(), "node")
