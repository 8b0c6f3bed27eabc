"""The service starts with the machine, reports to systemd, and logs what journald can read."""

from __future__ import annotations

import json
import logging
import os
import shlex
import socket
import sys
from pathlib import Path

import pytest

from halo_service.app.cli import main
from halo_service.app.install_service import MARK, serve_command, unit_text, windows_line
from halo_service.app.logs import formatter
from halo_service.app.service.systemd import Notifier

linux = pytest.mark.skipif(sys.platform != "linux", reason="systemd is Linux's")


@pytest.fixture(autouse=True)
def elsewhere(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path / "config"))


def value(text: str, key: str) -> str:
    (line,) = [line for line in text.splitlines() if line.startswith(f"{key}=")]
    return line.partition("=")[2]


@linux
def test_a_unit_is_written_that_runs_the_service_with_its_options(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("DISPLAY", ":0")
    options = ["--profile", "my desk", "--osc", "127.0.0.1:7000/flat,rate=60"]
    assert main(["install-service", *options]) == 0
    path = tmp_path / "config" / "systemd" / "user" / "halo.service"
    said = capsys.readouterr()
    assert said.out.strip() == str(path)
    assert "systemctl --user daemon-reload && systemctl --user enable --now halo" in said.err
    text = path.read_text()
    command = shlex.split(value(text, "ExecStart"))
    assert command[0] == sys.executable
    serve = command[command.index("serve") + 1 :]
    assert serve == [*options, "--source", "camera", "--wait", "3600"]
    assert (value(text, "Type"), value(text, "Restart")) == ("notify", "always")
    assert int(value(text, "WatchdogSec")) > 0
    assert value(text, "WorkingDirectory") == str(tmp_path)
    assert value(text, "Environment") == "DISPLAY=:0"


@linux
@pytest.mark.parametrize("xvfb_run", [None, "/usr/bin/xvfb-run"])
def test_without_a_display_the_unit_starts_a_virtual_one_or_says_what_is_missing(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, xvfb_run: str | None
) -> None:
    monkeypatch.delenv("DISPLAY", raising=False)
    monkeypatch.setattr("shutil.which", lambda _: xvfb_run)
    assert main(["install-service", "--print", "--source", "femto-bolt"]) == 0
    said = capsys.readouterr()
    command = shlex.split(value(said.out, "ExecStart"))
    assert ("apt install xvfb" in said.err) == (xvfb_run is None)
    assert command[:2] == (["/usr/bin/xvfb-run", "-a"] if xvfb_run else command[:2])
    assert command[-2:] == ["--wait", "3600"]
    assert value(said.out, "NotifyAccess") == ("all" if xvfb_run else "main")


@linux
def test_a_chosen_source_stays_and_a_file_of_others_too(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    command = ["install-service", "--print", "--source", "sim:demo,seed=3", "--wait", "5"]
    assert main(command) == 0
    assert value(capsys.readouterr().out, "ExecStart").endswith(
        "serve --source sim:demo,seed=3 --wait 5"
    )
    assert list(tmp_path.iterdir()) == []
    path = tmp_path / "config" / "systemd" / "user" / "mine.service"
    path.parent.mkdir(parents=True)
    path.write_text("[Service]\nExecStart=/bin/true\n")
    assert main(["install-service", "--name", "mine"]) == 2
    assert "was not written by halo; choose another --name" in capsys.readouterr().err
    path.write_text(MARK)
    assert main(["install-service", "--name", "mine"]) == 0
    assert "ExecStart" in path.read_text()


def test_a_wrong_option_is_refused_before_anything_is_written(tmp_path: Path) -> None:
    with pytest.raises(SystemExit) as refused:
        main(["install-service", "--profil", "desk"])
    assert refused.value.code == 2
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("word", ["plain", "two words", "50%", "$HOME", 'a"b', "C:\\x", ""])
def test_systemd_reads_each_word_as_it_was(word: str) -> None:
    text = value(unit_text(["halo", word], Path("/tmp")), "ExecStart")
    assert shlex.split(text.replace("%%", "%").replace("$$", "$")) == ["halo", word]


def test_on_windows_the_line_for_the_task_scheduler_is_printed() -> None:
    line = windows_line([r"C:\Program Files\python.exe", *serve_command([])[1:]], "halo")
    assert line.startswith("schtasks /Create /F /SC ONLOGON /TN halo /TR ")
    assert r'"\"C:\Program Files\python.exe\" -m halo_service.app.cli serve"' in line


@linux
def test_the_service_reports_that_it_is_ready_alive_and_ends(tmp_path: Path) -> None:
    now_s = 0.0
    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as manager:
        manager.bind(str(tmp_path / "notify"))
        environment = {
            "NOTIFY_SOCKET": str(tmp_path / "notify"),
            "WATCHDOG_USEC": "30000000",
            "WATCHDOG_PID": str(os.getpid()),
        }
        notifier = Notifier(environment, lambda: now_s)
        notifier.ready()
        for _ in range(299):  # half a minute of frames
            notifier.alive()
            now_s += 0.1
        notifier.stopping()
        manager.setblocking(False)
        said = []
        while True:
            try:
                said.append(manager.recv(100).decode())
            except BlockingIOError:
                break
    assert (said[0], said[-1]) == ("READY=1", "STOPPING=1")
    assert said[1:-1] == ["WATCHDOG=1"] * 3  # each third of 30 s


@linux
@pytest.mark.parametrize(
    "environment", [{}, {"NOTIFY_SOCKET": "/nowhere"}, {"NOTIFY_SOCKET": "@halo-nobody"}]
)
def test_without_systemd_nothing_happens(environment: dict[str, str]) -> None:
    notifier = Notifier(environment)
    notifier.ready()
    notifier.alive()
    notifier.stopping()


def record(level: int, text: str) -> logging.LogRecord:
    return logging.LogRecord("halo_service.x", level, "x.py", 1, text, (), None)


def test_log_lines_for_people_for_journald_and_as_json() -> None:
    warning = record(logging.WARNING, "camera: lost")
    assert formatter(False, {}).format(warning) == "halo: camera: lost"
    journal = formatter(False, {"JOURNAL_STREAM": "8:1"})
    assert journal.format(warning) == "<4>camera: lost"
    assert journal.format(record(logging.ERROR, "one\ntwo")) == "<3>one\n<3>two"
    line = json.loads(formatter(True, {}).format(warning))
    assert (line["level"], line["message"]) == ("warning", "camera: lost")
    assert line["time"].endswith("Z")
    assert line["logger"] == "halo_service.x"


def test_a_traceback_stays_in_one_line_of_json() -> None:
    try:
        raise ValueError("broken")
    except ValueError as error:
        failed = record(logging.ERROR, "sensing failed")
        failed.exc_info = (ValueError, error, error.__traceback__)
    text = formatter(True, {}).format(failed)
    assert "\n" not in text
    assert "ValueError: broken" in json.loads(text)["traceback"]
