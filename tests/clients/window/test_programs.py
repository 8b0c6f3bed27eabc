"""The clients as programs: clear error sentences, waiting, resuming, clean exit."""

from __future__ import annotations

import json
import os
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any

import pytest

from halo_protocol import Frame, encode_frame, event_to_json
from tests.ports import free_port

BIN = Path(sys.executable).parent
SOUND = {"halo-drums": ("--silent",), "halo-paint": (), "halo-type": ("--silent",)}
PROGRAMS = SOUND | {"halo-midi": ("--print",), "halo-lsl": ("--local",)}
"""All clients, without a device."""
Run = Callable[..., "subprocess.Popen[str]"]


@pytest.fixture
def run() -> Iterator[Run]:
    """Start a program without screen and loudspeaker; stop it at the end of the test."""
    started: list[subprocess.Popen[str]] = []

    def start(*command: str, screen: bool = True) -> subprocess.Popen[str]:
        env = {key: value for key, value in os.environ.items() if key != "SDL_VIDEODRIVER"}
        env |= {"SDL_VIDEODRIVER": "dummy"} if screen else {"DISPLAY": "", "WAYLAND_DISPLAY": ""}
        started.append(
            subprocess.Popen(
                [str(BIN / command[0]), *command[1:]],
                stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=env,
                start_new_session=True,
            )
        )  # fmt: skip
        return started[-1]

    yield start
    for process in started:
        with suppress(ProcessLookupError):  # also what it started, such as the two of a demo
            os.killpg(process.pid, signal.SIGKILL)
        process.communicate()


def read_line(process: subprocess.Popen[str], word: str, seconds: float = 20.0) -> str:
    """Return the next line on stderr that has this word."""
    assert process.stderr is not None
    until = time.monotonic() + seconds
    while time.monotonic() < until:
        line = process.stderr.readline()
        if word in line:
            return line
        assert line or process.poll() is None, f"ended without {word!r}"
    pytest.fail(f"no line with {word!r}")


@pytest.fixture
def both(run: Run) -> list[tuple[subprocess.Popen[str], int]]:
    """All clients, each with its own port; they start at the same time."""
    ports = [free_port() for _ in PROGRAMS]
    return [
        (run(program, *options, "--from", f"osc://127.0.0.1:{port}"), port)
        for (program, options), port in zip(PROGRAMS.items(), ports, strict=True)
    ]


def test_they_wait_for_a_service_and_ctrl_c_ends_them_cleanly(
    both: list[tuple[subprocess.Popen[str], int]], sender: Callable[[int, str], Any]
) -> None:
    for session in ("s1", "s2"):
        for process, _ in both:
            assert "is `halo serve` running" in read_line(process, "waiting")
        for process, port in both:
            sender(port, session)
            read_line(process, "frames come")
    for process, _ in both:
        process.send_signal(signal.SIGINT)
        _, rest = process.communicate(timeout=10)
        assert process.returncode == 0
        assert "Traceback" not in rest


def test_a_service_of_another_major_version_gives_one_sentence(
    both: list[tuple[subprocess.Popen[str], int]], wire: Any
) -> None:
    header = Frame("desk", "s1", 1, 1000, 0, 1)
    for process, port in both:
        read_line(process, "waiting")
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as out:
            for datagram in encode_frame("table", header, [wire.finger()], [], []):
                foreign = datagram.replace(b"/halo/1/", b"/halo/2/")
                assert foreign != datagram
                out.sendto(foreign, ("127.0.0.1", port))
        line = read_line(process, "speaks protocol 2")
        assert "this program speaks 1: install matching versions of both" in line
        process.send_signal(signal.SIGINT)
        _, rest = process.communicate(timeout=10)
        assert process.returncode == 0
        assert rest == ""


@pytest.fixture
def udp_port() -> int:
    return free_port()


@pytest.fixture
def sender(wire: Any) -> Callable[[int, str], None]:
    """A service that sends for half a second."""

    def send(port: int, session: str) -> None:
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as out:
            for number in range(15):
                header = Frame("desk", session, number, 1000, number * 33_333, 1)
                touching = [wire.finger(at=(100.0 + 5 * number, 90.0), pressure=0.6)]
                downs = [wire.down(at=(100.0, 90.0))] if number == 1 else []
                for datagram in encode_frame("table", header, touching, downs, []):
                    out.sendto(datagram, ("127.0.0.1", port))
                time.sleep(0.03)

    return send


@pytest.mark.parametrize("program", SOUND)
def test_without_a_screen_there_is_one_sentence(run: Run, program: str, udp_port: int) -> None:
    process = run(program, *SOUND[program], "--from", f"osc://127.0.0.1:{udp_port}", screen=False)
    _, error = process.communicate(timeout=20)
    if process.returncode != 2:
        pytest.skip("this machine has a screen")
    assert "no display to draw on" in error


@pytest.mark.parametrize("program", ["halo-drums", "halo-type"])
def test_without_a_sound_device_there_is_one_sentence(
    run: Run, program: str, udp_port: int
) -> None:
    if Path("/dev/snd").exists():
        pytest.skip("this machine has a sound device")
    process = run(program, "--from", f"osc://127.0.0.1:{udp_port}")
    _, error = process.communicate(timeout=20)
    assert process.returncode == 2
    assert error.startswith(f"{program}: no sound device (")
    assert ("--midi" in error) == (program == "halo-drums")
    assert error.count("\n") == 1


def test_without_midi_there_is_one_sentence(run: Run, udp_port: int) -> None:
    if Path("/dev/snd/seq").exists():
        pytest.skip("this machine has MIDI")
    process = run("halo-midi", "--from", f"osc://127.0.0.1:{udp_port}")
    _, error = process.communicate(timeout=20)
    assert process.returncode == 2
    assert error.startswith("halo-midi: no MIDI port can be created on this machine (")
    assert "--print, which needs none" in error and error.count("\n") == 1


@pytest.mark.parametrize(
    ("command", "message"),
    [
        (("halo-drums", "--silent", "--from", "nonsense"), "unknown source 'nonsense'"),
        (("halo-drums", "--render", "a.wav"), "need a recorded stream"),
        (("halo-lsl", "--local", "--from", "none.jsonl"), "cannot read none.jsonl"),
        (("halo-lsl", "--delay", "-5"), "'-5' is not a number from 0 to 10000"),
        (("halo-lsl", "--delay", "nan"), "'nan' is not a number from 0 to 10000"),
        (("halo-midi", "--render", "a.mid"), "needs a recorded stream"),
        (("halo-midi", "--from", "a.jsonl", "--render", "a.mp3"), "is neither a .mid nor a .wav"),
        (("halo-midi", "--root", "H2"), "'H2' is not a note"),
        (("halo-midi", "--bend", "97"), "'97' is not a number from 1 to 96"),
        (("halo-midi", "--soft", "500"), "--loud 400 must be above --soft 500"),
        (("halo-paint", "--from", "none.jsonl", "--render", "a.png"), "cannot read none.jsonl"),
        (("halo-paint", "--render", "a.png"), "needs a recorded stream"),
        (("halo-type", "--render", "a.csv"), "needs a recorded stream"),
        (("halo-paint", "--from", "a.jsonl", "--render", "a.gif"), "is neither a .png nor a .svg"),
        (
            ("halo", "demo", "flute"),
            "unknown client 'flute'; choose from: drums, midi, paint, type",
        ),
    ],
)
def test_wrong_use_gives_one_sentence(run: Run, command: tuple[str, ...], message: str) -> None:
    process = run(*command)
    _, error = process.communicate(timeout=20)
    assert process.returncode == 2
    assert message in error
    assert "Traceback" not in error


@pytest.mark.parametrize(
    ("program", "option", "name"),
    [
        ("halo-drums", "--render", "it.wav"),
        ("halo-drums", "--picture", "it.png"),
        ("halo-midi", "--render", "it.mid"),
        ("halo-paint", "--render", "it.svg"),
        ("halo-paint", "--render", "it.png"),
    ],
)
def test_a_file_is_written_and_named_and_a_missing_folder_gives_one_sentence(
    run: Run, program: str, option: str, name: str, wire: Any, tmp_path: Path
) -> None:
    frames = [wire.frame(0), wire.frame(1, [wire.finger(pressure=0.5)], downs=(wire.down(),))]
    stream = tmp_path / "recording.jsonl"
    stream.write_text("".join(json.dumps(event_to_json(frame)) + "\n" for frame in frames))
    for path, code in ((tmp_path / name, 0), (tmp_path / "missing" / name, 2)):
        process = run(program, "--from", str(stream), option, str(path))
        out, error = process.communicate(timeout=20)
        assert process.returncode == code, error
        assert path.exists() == (code == 0)
        line = out if code == 0 else error
        assert str(path) in line and line.count("\n") == 1


@pytest.mark.parametrize(
    ("program", "word"),
    [
        ("halo-drums", "hover low"),
        ("halo-paint", "calligraphy"),
        ("halo-type", "words a minute"),
    ],
)
def test_the_help_explains_how_to_use_it(run: Run, program: str, word: str) -> None:
    out, _ = run(program, "--help").communicate(timeout=20)
    assert word in out


@pytest.mark.slow
def test_a_demo_starts_two_programs_and_ctrl_c_ends_both(run: Run) -> None:
    # A quarter of the pixels: drawn and calibrated sooner.
    source = "sim:drumming,mode=NFOV_2X2BINNED"
    process = run("halo", "demo", "drums", "--source", source, "--silent")
    read_line(process, "the service sends; drums starts", 90.0)
    until = time.monotonic() + 10.0
    children: list[str] = []
    while len(children) < 2 and time.monotonic() < until:
        children = Path(f"/proc/{process.pid}/task/{process.pid}/children").read_text().split()
    assert len(children) == 2
    process.send_signal(signal.SIGINT)
    process.communicate(timeout=30)
    assert process.returncode == 0
    assert not any(Path(f"/proc/{child}").exists() for child in children)
