"""Settings are written into the user's file, and everything else in it stays."""

from __future__ import annotations

from pathlib import Path

import pytest

from halo_service.errors import UserError
from halo_service.settings import Settings, load
from halo_service.settings.write import Change, changed_text, write

FILE = """\
# The stage on Monday.
node = "stage"   # not "table"

[sensing]
# Wood needs more.
halo_threshold_mm = 6.5
down_level = 0.25

[osc]
destinations = [
    "127.0.0.1:4256",  # monitor
]
"""


def test_comments_order_and_other_lines_stay() -> None:
    changes = [
        Change("sensing", "halo_threshold_mm", 7.0),
        Change("", "node", "hall"),
        Change("sensing", "down_level", None),
        Change("tuio", "destinations", ["127.0.0.1"]),
    ]
    assert (
        changed_text(FILE, changes)
        == FILE.replace("6.5", "7.0")
        .replace('"stage"   #', '"hall"   #')
        .replace("down_level = 0.25\n", "")
        + '\n[tuio]\ndestinations = ["127.0.0.1"]\n'
    )


def test_a_file_is_made_where_there_is_none(tmp_path: Path) -> None:
    path = tmp_path / "halo.toml"
    path.write_text("")
    after = write(path, [Change("sensing", "fingers", "all"), Change("osc", "max_bytes", 1432)])
    assert load(path) == after
    assert (after.sensing.fingers, after.osc.max_bytes) == ("all", 1432)


@pytest.mark.parametrize(
    ("change", "says"),
    [
        (Change("sensing", "up_level", 0.9), "'up_level' must be below 'down_level'"),
        (Change("sensing", "hover_range_mm", -1), "hover_range_mm"),
        (Change("sensing", "hover_range_mm", "far"), "a number"),
        (Change("sensing", "nothing", 1), "nothing"),
        (Change("nothing", "node", 1), "nothing"),
        (Change("web", "port", 70_000), "port"),
        (Change("", "node", "NOT a name"), "node"),
        (Change("osc", "destinations", "127.0.0.1:1"), "a list of text"),
    ],
)
def test_what_is_not_allowed_is_not_written(tmp_path: Path, change: Change, says: str) -> None:
    path = tmp_path / "halo.toml"
    path.write_text(FILE)
    with pytest.raises(UserError, match=says):
        write(path, [change])
    assert path.read_text() == FILE


def test_a_file_that_cannot_be_read_is_not_replaced(tmp_path: Path) -> None:
    path = tmp_path / "halo.toml"
    path.write_text("[sensing\n")
    with pytest.raises(UserError, match="cannot be read"):
        write(path, [Change("", "node", "hall")])
    assert path.read_text() == "[sensing\n"


def test_every_setting_at_its_default_leaves_an_empty_file(tmp_path: Path) -> None:
    path = tmp_path / "halo.toml"
    path.write_text('node = "stage"\n')
    assert write(path, [Change("", "node", None)]) == Settings()
    assert path.read_text() == ""
