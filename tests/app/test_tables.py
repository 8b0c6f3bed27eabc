"""A table is ruled on a terminal, and plain lines elsewhere."""

from __future__ import annotations

import os
import re
from collections.abc import Callable
from pathlib import Path

import pytest

from halo_service.app.cli import main
from halo_service.app.discovery import Service, format_service
from halo_service.app.discovery import table_of as services_table
from halo_service.app.doctor import Finding, format_finding
from halo_service.app.doctor import table_of as findings_table
from halo_service.app.tables import print_tables
from halo_service.evaluation.report.table import Table
from halo_service.profile import Profile
from halo_service.profile.store import save
from tests.terminal import needs_terminal, shown, terminal

OnTerminal = Callable[[Callable[[], object]], str]
LONG = "/a/very/long/path/" + 9 * "of/many/folders/"
FIRST = Table("of [1]", ("", "check", "state"), (("MISSING", "model", LONG), ("ok", "[x]", "all")))
SECOND = Table("", ("goal", "value"), (("latency", "3.00"),), "Note [2].")
RULE = "─"


def plain_text(shown_text: str) -> str:
    return re.sub(r"\x1b\[[0-9;]*m", "", shown_text)


@pytest.fixture
def on_terminal(monkeypatch: pytest.MonkeyPatch) -> OnTerminal:
    """Run something with a terminal of 80 columns as its stdout; return what is shown."""

    def run(action: Callable[[], object]) -> str:
        monkeypatch.setenv("TERM", "xterm")
        monkeypatch.setenv("COLUMNS", "80")
        monkeypatch.delenv("NO_COLOR", raising=False)
        with terminal() as (ours, theirs):
            with os.fdopen(theirs, "w", encoding="utf-8") as stdout, monkeypatch.context() as patch:
                patch.setattr("sys.stdout", stdout)
                action()
            return shown(ours)

    return run


@needs_terminal
def test_a_terminal_gets_ruled_tables_with_all_words(
    on_terminal: OnTerminal,
) -> None:
    coloured = on_terminal(lambda: print_tables(FIRST, SECOND, plain="for programs"))
    text = plain_text(coloured)
    assert "for programs" not in text
    assert "\x1b[1;31mMISSING" in coloured
    assert text.count(RULE) > 40
    assert all(len(line) <= 80 for line in text.splitlines())
    words = "".join(text.split())
    # A long path is folded, never cut; brackets are words and no markup.
    for part in ("of[1]", "[x]", "latency", "Note[2].", LONG[:40]):
        assert part in words
    assert LONG in "".join(re.findall(r"[a-z/]+", text[text.index("/a/very") : text.index("[x]")]))


@pytest.mark.parametrize("plain", [None, "left  table  30 Hz"])
def test_a_pipe_gets_plain_lines(plain: str | None, capsys: pytest.CaptureFixture[str]) -> None:
    print_tables(FIRST, SECOND, plain=plain)
    printed = capsys.readouterr().out
    assert RULE not in printed and "\x1b" not in printed
    if plain is None:
        assert LONG in printed
        assert "\n\n\ngoal     value\n-------  -----\nlatency  3.00\n\nNote [2].\n" in printed
    else:
        assert printed == f"{plain}\n"


@needs_terminal
def test_profiles_are_ruled(
    on_terminal: OnTerminal, profile: Profile, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("halo_service.app.profiles.profiles_path", lambda: tmp_path)
    save(profile, tmp_path / "desk")
    (tmp_path / "old").mkdir()
    (tmp_path / "old" / "profile.json").write_text("{")
    listed = plain_text(on_terminal(lambda: main(["profile", "list"])))
    rows = [line.split() for line in listed.splitlines() if RULE not in line and line.strip()]
    assert rows[0] == ["profile", "calibrated", "camera"]
    assert [rows[1][0], rows[1][-1]] == ["drawn", "DRAWN"]
    assert rows[2][0] == "old"
    described = plain_text(on_terminal(lambda: main(["profile", "show", str(tmp_path / "desk")])))
    assert re.search(r"surface +table, 300 x 200 mm", described)
    assert re.search(r"all fingers +touch 2000 mm px", described)


SERVICE = Service("left", "table", "s1", 30.0, "mdns", "127.0.0.1:4257")


@pytest.mark.parametrize(
    ("table", "plain", "rows"),
    [
        (
            findings_table(
                [Finding("camera", False, "none", "plug it in"), Finding("x", True, "y")]
            ),
            format_finding(Finding("camera", False, "none", "plug it in")),
            (("MISSING", "camera", "none", "plug it in"), ("ok", "x", "y", "")),
        ),
        (
            services_table([SERVICE]),
            format_service(SERVICE),
            (("left", "table", "30 Hz", "mdns", "127.0.0.1:4257"),),
        ),
    ],
    ids=["doctor", "list"],
)
def test_a_row_has_the_words_of_its_line(
    table: Table, plain: str, rows: tuple[tuple[str, ...], ...]
) -> None:
    assert table.rows == rows
    assert all(len(row) == len(table.head) for row in rows)
    assert [word for cell in rows[0] for word in cell.split()] == re.findall(
        r"[^\s;]+[^\s;:]", plain
    )
