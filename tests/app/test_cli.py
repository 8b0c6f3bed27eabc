"""Bad input gets one sentence with the remedy, exit 2, and leaves nothing behind."""

from __future__ import annotations

import os
import signal
import socket
import subprocess
import sys
from collections.abc import Callable
from importlib.metadata import entry_points
from pathlib import Path

import pytest

from halo_service.app import __main__ as start
from halo_service.app.cli import main
from halo_service.app.options import found_at
from halo_service.app.parser import COMMANDS, parse
from halo_service.app.process import endings, give_matplotlib_a_folder, stop_on_signals

HALO = Path(sys.executable).with_name("halo")


def halo(*arguments: str | Path, cwd: Path) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [HALO, *map(str, arguments)], cwd=cwd, capture_output=True, text=True, timeout=60
    )


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (
            ["serve", "--source", "kinect2"],
            "source: unknown source 'kinect2'; did you mean 'azure-kinect'?",
        ),
        (["serve", "--source", "femto"], "did you mean 'femto-bolt' or 'femto-mega'?"),
        (["serve", "--source", "recording:none.mkv"], "none.mkv does not exist"),
        (
            ["first-light", "out", "--profile", "p", "--source", "recording:none.mkv"],
            "first-light: a recording cannot follow prompts; name a camera",
        ),
        (["serve", "--source", "recording:"], "did you mean 'recording:FILE'?"),
        (["serve", "--source", "webcam"], "unknown source 'webcam'; choose from: azure-kinect,"),
        (["serve", "--source", "sim:nowhere"], "has no scenario 'nowhere'; choose from: demo,"),
        (["serve", "--source", "sim", "--loop"], "--loop and --fast work only with"),
        (["serve", "--source", "azure-kinect"], "no Azure Kinect is plugged in"),
        (["serve", "--config", "none.toml"], "none.toml cannot be read"),
        (
            ["serve", "--config", "bad.toml"],
            "osc: unknown key 'prot'; known: enabled, destinations",
        ),
        (["serve", "--osc", "nowhere"], "'nowhere' is not a destination; write host:port"),
        (["serve", "--node", "My Desk"], "node must be 1 to 32 of a-z 0-9 _ -"),
        (["serve", "--zenoh-listen", "tcp/256.0.0.1:1"], "zenoh: cannot listen at"),
        (["serve", "--profile", "./none", "--source", "sim"], "there is no profile at none"),
        (["bench", "--seconds", "0"], "--seconds must be from 1 to 60"),
        (["bench", "--source", "sim:nowhere"], "has no scenario 'nowhere'; choose from: demo,"),
        (["bench", "--source", "azure-kinect"], "'halo record' makes a recording of a camera"),
        (
            ["bench", "--source", "recording:none.mkv"],
            "a recording needs the profile of its place: --profile P",
        ),
        (["replay", "none.mkv", "--jsonl", "out.jsonl"], "none.mkv does not exist"),
        (["replay", "bad.toml", "--jsonl", "out.jsonl"], "not a Matroska file"),
    ],
)
def test_one_sentence_and_exit_2(
    arguments: list[str],
    says: str,
    tmp_path: Path,
    free_port: Callable[[], int],
    monkeypatch: pytest.MonkeyPatch,
    capfd: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "bad.toml").write_text("[osc]\nprot = 4256\n")
    if arguments[0] == "serve":
        arguments = [*arguments, "--control-port", str(free_port())]
        if "--zenoh-listen" not in arguments:
            arguments.append("--no-zenoh")
    assert main(arguments) == 2
    printed = capfd.readouterr()
    assert says in printed.err
    assert "Traceback" not in printed.err
    assert printed.out == ""
    assert [path.name for path in tmp_path.iterdir()] == ["bad.toml"]


def test_a_control_port_in_use_is_one_sentence_and_another_port(
    spawn: Callable[..., subprocess.Popen[str]],
) -> None:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as taken:
        taken.bind(("127.0.0.1", 0))
        port = str(taken.getsockname()[1])
        options = ("--no-zenoh", "--no-osc", "--source", "sim:idle", "--control-port", port)
        service = spawn(HALO, "serve", *options)
        assert service.stderr is not None
        first = service.stderr.readline()
    assert first.startswith(f"halo: control: port {port} is in use, so this service uses ")


def test_debug_shows_the_traceback(tmp_path: Path) -> None:
    result = halo("replay", "none.mkv", "--jsonl", "-", "--debug", cwd=tmp_path)
    assert result.returncode != 0
    assert "Traceback" in result.stderr


CHATTER = """
import logging
from halo_service.app.cli import main
main(["profile", "list"])
for name in ("matplotlib.font_manager", "halo_service.app", "halo_calibration.steps"):
    logging.getLogger(name).info("%s speaks", name)
    logging.getLogger(name).warning("%s warns", name)
"""


def test_libraries_are_heard_only_when_they_warn(tmp_path: Path) -> None:
    said = subprocess.run(
        [sys.executable, "-c", CHATTER], cwd=tmp_path, capture_output=True, text=True, timeout=60
    ).stderr
    assert "font_manager speaks" not in said
    assert "halo: halo_service.app speaks" in said
    assert "halo: halo_calibration.steps speaks" in said
    assert "halo: matplotlib.font_manager warns" in said


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (["srve"], "halo: unknown command 'srve'; did you mean 'serve'?"),
        (["xyz"], "halo: unknown command 'xyz'; choose from: serve, monitor, demo,"),
        (["--verson"], "halo: unknown option '--verson'; did you mean '--version'?"),
        (
            ["serve", "--sorce", "x"],
            "halo serve: unknown option '--sorce'; did you mean '--source'?",
        ),
        (["replay", "x.mkv", "--jsnl", "y"], "unknown option '--jsnl'; did you mean '--jsonl'?"),
        (["monitor", "--frm=x"], "halo monitor: unknown option '--frm'; did you mean '--from'?"),
        (["profile", "lst"], "halo profile: unknown action 'lst'; did you mean 'list'?"),
        (["calibrate", "tuch"], "halo calibrate: unknown step 'tuch'; did you mean 'touch'?"),
        (["demo", "drms"], "halo demo: unknown client 'drms'; did you mean 'drums'?"),
        (["bench", "--hands", "3"], "halo bench: unknown --hands '3'; choose from: 1, 2"),
        (["record", "a.mkv", "b.mkv"], "halo record: unexpected argument 'b.mkv'"),
    ],
)
def test_a_typo_gets_the_nearest_word_and_exit_2(
    arguments: list[str], says: str, capfd: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit) as left:
        main(arguments)
    assert left.value.code == 2
    assert says in capfd.readouterr().err


def test_a_demo_forwards_the_options_that_it_does_not_know() -> None:
    options = parse(["demo", "drums", "--source", "sim:demo", "--mute", "--rate", "3"])
    assert options.source == "sim:demo"
    assert options.rest == ["--mute", "--rate", "3"]


@pytest.mark.parametrize(
    ("client", "option"),
    [("drums", "--left-handed"), ("paint", "--brush"), ("type", "--layout"), (None, None)],
)
def test_the_help_of_a_demo_has_the_options_of_its_client(
    client: str | None, option: str | None, capfd: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit) as left:
        main(["demo", *([client] if client else []), "--help"])
    assert left.value.code == 0
    text = capfd.readouterr().out
    assert "--source SIM" in text
    assert option is None or option in text
    assert ("options of the client" in text) == (client is not None)


HEAVY = ("numpy", "cv2", "mediapipe", "zenoh", "sklearn", "scipy", "av", "rich", "pydantic")
IMPORTS = """
import sys
from halo_service.app.cli import main
try:
    main(sys.argv[2:])
except SystemExit:
    pass
print("imported:", *(name for name in sys.argv[1].split(",") if name in sys.modules))
"""


@pytest.mark.parametrize(
    "verb", [[], *([name] for name in COMMANDS)], ids=lambda verb: " ".join(verb)
)
def test_help_has_an_example_and_imports_nothing_heavy(verb: list[str]) -> None:
    script = [sys.executable, "-c", IMPORTS, ",".join(HEAVY), *verb, "--help"]
    result = subprocess.run(script, capture_output=True, text=True, timeout=60)
    *shown, imported = result.stdout.splitlines()
    assert imported == "imported:"
    assert shown[0].startswith(" ".join(["usage: halo", *verb]))
    assert shown[-1].startswith("  halo " if verb else "'halo COMMAND --help'")


@pytest.mark.skipif(not hasattr(signal, "SIGHUP"), reason="Windows has no such signal")
def test_a_terminal_that_closes_ends_a_program_unless_nohup_keeps_it() -> None:
    def ended_by(number: int) -> list[int]:
        calls: list[int] = []
        before = [(each, signal.getsignal(each)) for each in (*endings(), signal.SIGHUP)]
        try:
            stop_on_signals(lambda: calls.append(number))
            os.kill(os.getpid(), number)
            return calls
        finally:
            for each, handler in before:
                signal.signal(each, handler)

    before = signal.signal(signal.SIGHUP, signal.SIG_DFL)  # these tests, too, may run under nohup
    try:
        for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
            assert ended_by(number) == [number]
        signal.signal(signal.SIGHUP, signal.SIG_IGN)
        assert ended_by(signal.SIGHUP) == []
    finally:
        signal.signal(signal.SIGHUP, before)


@pytest.mark.parametrize("module", ["halo_service.app.cli", "halo_service.app.parser"])
def test_ctrl_c_while_the_program_is_imported_ends_it_in_silence(module: str) -> None:
    """Ctrl-C comes with the import of a module."""
    assert entry_points(group="console_scripts")["halo"].value == f"{start.__name__}:main"
    script = f"""
import os, signal, sys
from {start.__name__} import main

class CtrlC:
    def find_spec(self, name, path=None, target=None):
        if name == "{module}":
            os.kill(os.getpid(), signal.SIGINT)

signal.signal(signal.SIGINT, signal.default_int_handler)
sys.meta_path.insert(0, CtrlC())
sys.argv = ["halo", "serve", "--source", "sim"]
sys.exit(main())
"""
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, timeout=60)
    assert (done.returncode, done.stdout, done.stderr) == (start.STOPPED, b"", b"")


@pytest.mark.skipif(
    sys.platform != "linux", reason="/proc is a folder that is read-only for everyone"
)
def test_in_a_read_only_home_matplotlib_gets_a_folder_and_prints_nothing(tmp_path: Path) -> None:
    writable = {"HOME": str(tmp_path)}
    give_matplotlib_a_folder(writable)
    assert "MPLCONFIGDIR" not in writable
    read_only = {"HOME": "/proc/self"}
    give_matplotlib_a_folder(read_only)
    assert os.access(read_only["MPLCONFIGDIR"], os.W_OK)
    script = "import matplotlib, logging; matplotlib.get_configdir()"
    done = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, env=os.environ | read_only
    )
    assert (done.returncode, done.stderr) == (0, "")


def test_the_log_names_the_settings_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    assert found_at(None) == f"defaults (no halo.toml in {tmp_path})"
    (tmp_path / "halo.toml").write_text("")
    assert found_at(None) == str(tmp_path / "halo.toml")
    assert found_at(Path("other.toml")) == str(tmp_path / "other.toml")


@pytest.mark.parametrize("wait", ["-1", "nan", "inf", "soon"])
def test_a_wrong_wait_is_refused(wait: str) -> None:
    with pytest.raises(SystemExit) as refused:
        parse(["serve", "--wait", wait])
    assert refused.value.code == 2
