"""Options that write a file of a recorded stream, and wrong options: without starting a program."""

from __future__ import annotations

import json
from importlib import import_module
from pathlib import Path
from typing import Any

import pytest

from halo_protocol import event_to_json


def run(client: str, *options: str) -> int:
    try:
        return int(import_module(f"halo_{client}.app").main(options))
    except SystemExit as left:  # argparse
        return int(left.code or 0)


@pytest.fixture
def stream(wire: Any, tmp_path: Path) -> str:
    frames = [wire.frame(0), wire.frame(1, [wire.finger(pressure=0.5)], downs=(wire.down(),))]
    path = tmp_path / "recording.jsonl"
    path.write_text("".join(json.dumps(event_to_json(frame)) + "\n" for frame in frames))
    return str(path)


@pytest.mark.parametrize(
    ("client", "option", "name"),
    [
        ("drums", "--animate", "it.svg"),
        ("paint", "--animate", "it.svg"),
        ("type", "--animate", "it.svg"),
        ("type", "--render", "it.csv"),
    ],
)
def test_a_file_is_written_and_named_and_a_missing_folder_gives_one_sentence(
    client: str,
    option: str,
    name: str,
    stream: str,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:
    for path, code in ((tmp_path / name, 0), (tmp_path / "missing" / name, 2)):
        assert run(client, "--from", stream, option, str(path)) == code
        out, error = capsys.readouterr()
        assert path.exists() == (code == 0)
        line = out if code == 0 else error
        assert str(path) in line and line.count("\n") == 1


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (("drums", "--animate", "a.svg"), "need a recorded stream"),
        (("paint", "--animate", "a.svg"), "--animate needs a recorded stream"),
        (("type", "--animate", "a.svg"), "--animate needs a recorded stream"),
        (("type", "--layout", "dvorak"), "choose from qwerty, qwertz, azerty"),
        (("type", "--phrases", "none.txt"), "cannot read none.txt"),
        (("type", "--seed", "-3"), "'-3' is not a number of at least 0"),
        (("type", "--tasks", ","), "give at least one name"),
        (("type", "--pause", "nan"), "'nan' is not a number of at least 0.2"),
        (("type", "--results", "none/a.csv"), "there is no folder none"),
        (("type", "--results", "/dev/null"), "/dev/null exists"),
    ],
)
def test_wrong_options_give_one_sentence(
    options: tuple[str, ...], message: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(*options) == 2
    error = capsys.readouterr().err
    assert message in error
    assert error.splitlines()[-1].startswith(f"halo-{options[0]}: ")
