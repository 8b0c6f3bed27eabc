"""The monitor shows what arrives, as a picture and as JSON, and ends as its options say."""

import json
import os
import signal
import subprocess
import sys
from collections.abc import Callable, Iterable
from dataclasses import replace
from typing import Any

import pytest

from halo_client import KnownServices, Losses
from halo_protocol import Down, Health, Pointer, Report, Scene, TouchFrame
from halo_tools.monitor import main
from halo_tools.monitor_view import HEADINGS, View

MONITOR = [sys.executable, "-m", "halo_tools.monitor"]
POINTER = Pointer(7, 0, 2, 1, 1, 0.5, 0.5, 150.0, 100.0, 0.0, 0.62, 0.0, 0.0, 0.9, 3, 128.0)


def picture(
    *frames: TouchFrame,
    scene: Scene | None = None,
    health: Health | None = None,
    unix_us: int = 1_000_000,
) -> str:
    view, known = View(), KnownServices()
    for number, frame in enumerate(frames):
        view.update(frame, 1.0 + number / 10, unix_us)
    if scene is not None:
        known.update(Report("table", scene))
    if health is not None:
        known.update(Report("table", health))
    return "\n".join(view.lines("osc://here", known, Losses(missed=4, bad=2), 1.5))


def frame(pointers: Iterable[Pointer] = (), time_us: int = 988_000, **more: Any) -> TouchFrame:
    return TouchFrame("table", "desk", "s1", 41, time_us, tuple(pointers), **more)


def scene(source: int) -> Scene:
    return Scene("desk", "s1", "1.0.0", 300.0, 200.0, 2, 3, source, 30.0)


def test_the_picture_shows_each_pointer() -> None:
    (line,) = [line for line in picture(frame([POINTER])).splitlines() if "index" in line]
    shown = "7 0 right index TOUCH 150.0 100.0 0.0 0.62 128 0.90 3"
    assert line.split() == shown.split()
    assert len(line) == len(HEADINGS) <= 80


def test_the_picture_shows_rate_latency_losses_and_touches() -> None:
    hit = Down(7, 0, 0.5, 0.5, 180.0, 3.0, 3)
    text = picture(frame(), frame(missed=4), frame([POINTER], downs=(hit,)))
    assert "3 a second" in text
    assert "latency 12.0 ms" in text
    assert "lost frames: 0 in the service, 4 on the way" in text
    assert "bad 2" in text
    assert "down 7#3 (180 mm/s)" in text


@pytest.mark.parametrize(
    ("source", "says"),
    [(2, "VIRTUAL CAMERA"), (1, "RECORDING"), (0, "source camera"), (9, "source 9")],
)
def test_the_picture_says_loudly_what_is_behind_it(source: int, says: str) -> None:
    text = picture(frame(), scene=scene(source))
    assert says in text
    assert ("!!" in text) == (source in (1, 2))


@pytest.mark.parametrize(
    ("changes", "says"),
    [
        ({"profile_fit": 1}, ""),
        ({"profile_fit": 0, "memory_mb": 412}, ""),
        ({"fps": 12.0, "profile_fit": 1}, "!! SLOW: the service senses 12 of 30 Hz !!"),
        (
            {"profile_fit": 3},
            "!! PROFILE DOES NOT FIT: camera or table was tilted since the calibration !!",
        ),
        ({"profile_fit": 9}, ""),
        ({"zenoh_missing": 1}, "!! ZENOH: 1 of its routers or peers are away !!"),
        ({"load": 1, "looks_hz": 9.8}, "!! BUSY MACHINE: new fingers appear a little later !!"),
        ({"load": 3}, "appear later, and camera frames are left out !!"),
        ({"load": 9}, ""),
        ({"write_errors": 2}, "!! NOT SAVED: the service could not write its profile; see its log"),
    ],
)
def test_the_picture_says_loudly_what_is_wrong(changes: dict[str, Any], says: str) -> None:
    health = replace(Health("desk", "s1", 29.5, 3.5, 640, 0, 3, 1, 33.0), **changes)
    text = picture(frame(), scene=scene(0), health=health)
    assert says in text
    assert ("!!" in text) == bool(says)
    assert "lost frames: 640 in the service" in text


def test_a_canvas_says_how_many_surfaces_it_merges_and_how_far_clocks_are_off() -> None:
    health = Health("desk", "s1", 29.5, 0.3, 0, 0, 3, 1, 33.0)
    merged = replace(health, nodes=2, clock_offset_ms=-5000.5, clock_deviation_ms=0.25)
    said = "canvas of 2 surfaces · clocks up to 5000.5 ms off (+- 0.2 ms)"
    assert said in picture(frame(), scene=scene(0), health=merged)
    assert "canvas" not in picture(frame(), scene=scene(0), health=health)


def test_a_recordings_time_has_no_latency() -> None:
    assert "latency - (a recording's time)" in picture(frame(time_us=1), unix_us=10**15)


def test_words_of_a_later_version_are_shown_as_numbers() -> None:
    strange = Pointer(7, 0, 5, 9, 4, *(0.0,) * 9, 3, -1.0)
    assert "    7    0 5       9      4     " in picture(frame([strange]))


def test_nothing_yet_is_said_in_a_sentence() -> None:
    assert "waiting: no frames at osc://here yet; is `halo serve` running" in picture()


def run(url: str, *options: str) -> subprocess.CompletedProcess[str]:
    command = [*MONITOR, "--from", url, *options]
    return subprocess.run(command, capture_output=True, text=True, timeout=30)


def test_json_is_a_line_for_each_event(
    udp_service: Callable[..., Any], free_port: int, repeat: Callable[[Callable[[], object]], None]
) -> None:
    service = udp_service(free_port)
    repeat(lambda: (service.scene(), service.health(), service.tap()))
    done = run(f"osc://127.0.0.1:{free_port}", "--json", "--frames", "12")
    assert done.returncode == 0, done.stderr
    lines = [json.loads(line) for line in done.stdout.splitlines()]
    kinds = {kind: [x for x in lines if x["kind"] == kind] for kind in ("frame", "scene", "health")}
    assert len(kinds["frame"]) >= 12
    assert kinds["scene"][0]["source"] == "virtual"
    assert kinds["health"][0]["tracker"] == "tracking"
    touch = next(x for x in kinds["frame"] if x["pointers"] and x["pointers"][0]["pressure"])
    assert touch["pointers"][0]["state"] == "touch"
    assert touch["pointers"][0]["finger"] == "index"
    assert 0 <= touch["received_us"] - touch["time_us"] < 5_000_000


def test_a_pipe_gets_pictures_without_control_codes(
    udp_service: Callable[..., Any], free_port: int, repeat: Callable[[Callable[[], object]], None]
) -> None:
    service = udp_service(free_port)
    repeat(lambda: (service.scene(), service.tap()))
    done = run(f"osc://127.0.0.1:{free_port}", "--seconds", "1.5")
    assert done.returncode == 0, done.stderr
    assert "VIRTUAL CAMERA" in done.stdout
    assert "\x1b" not in done.stdout


def test_zenoh_is_shown_too(
    zenoh_service: Callable[..., Any],
    free_tcp_port: int,
    repeat: Callable[[Callable[[], object]], None],
) -> None:
    endpoint = f"tcp/127.0.0.1:{free_tcp_port}"
    service = zenoh_service(endpoint)
    repeat(service.tap)
    done = run(f"zenoh://?connect={endpoint}", "--json", "--frames", "5")
    assert done.returncode == 0, done.stderr
    assert len(done.stdout.splitlines()) >= 5


def test_too_few_frames_are_a_failure(free_port: int) -> None:
    done = run(f"osc://127.0.0.1:{free_port}", "--json", "--frames", "1", "--seconds", "0.2")
    assert done.returncode == 1
    assert "0 of 1 frames came" in done.stderr


def test_json_says_on_the_side_that_nothing_comes(free_port: int) -> None:
    done = run(f"osc://127.0.0.1:{free_port}", "--json", "--seconds", "2.3")
    assert done.returncode == 0
    assert done.stdout == ""
    assert done.stderr.count("waiting: no frames") == 1


def test_ctrl_c_is_a_good_end(free_port: int) -> None:
    command = [*MONITOR, "--from", f"osc://127.0.0.1:{free_port}"]
    with subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    ) as monitor:
        assert monitor.stdout is not None
        assert "halo monitor" in monitor.stdout.readline()
        monitor.send_signal(signal.SIGINT)
        _, complaints = monitor.communicate(timeout=10)
    assert monitor.returncode == 0
    assert complaints == ""


def test_a_reader_that_leaves_is_a_good_end(
    udp_service: Callable[..., Any], free_port: int, repeat: Callable[[Callable[[], object]], None]
) -> None:
    service = udp_service(free_port)
    repeat(service.tap)
    command = [*MONITOR, "--from", f"osc://127.0.0.1:{free_port}", "--json"]
    with subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    ) as monitor:
        assert monitor.stdout is not None
        assert monitor.stderr is not None
        monitor.stdout.readline()
        monitor.stdout.close()
        assert monitor.wait(timeout=10) == 0
        assert monitor.stderr.read() == ""


def test_a_wrong_source_is_one_sentence(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["--from", "nonsense"]) == 2
    said = capsys.readouterr().err
    assert said.startswith("halo-monitor: unknown source 'nonsense'; use osc://")
    assert said.count("\n") == 1


@pytest.mark.parametrize("option", [["--frames", "0"], ["--seconds", "-1"], ["--seconds", "nan"]])
def test_a_wrong_limit_is_refused(option: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as refused:
        main(option)
    assert refused.value.code == 2
    assert "must be" in capsys.readouterr().err


def test_a_terminal_is_drawn_over_in_place(
    udp_service: Callable[..., Any], free_port: int, repeat: Callable[[Callable[[], object]], None]
) -> None:
    pty = pytest.importorskip("pty", reason="this system has no pseudo-terminals")
    repeat(udp_service(free_port).tap)
    ours, theirs = pty.openpty()
    command = [*MONITOR, "--from", f"osc://127.0.0.1:{free_port}", "--seconds", "0.6"]
    with subprocess.Popen(command, stdout=theirs) as monitor:
        assert monitor.wait(timeout=10) == 0
    os.close(theirs)
    shown = os.read(ours, 1 << 16).decode()
    os.close(ours)
    first, *over = shown.split("\x1b[J")[1:]
    assert "halo monitor" in first
    assert over
    assert all("halo monitor" in picture for picture in over)
