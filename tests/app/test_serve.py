"""`halo serve`, started as a user starts it, received by external programs."""

from __future__ import annotations

import re
import signal
import socket
import struct
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import pytest

import halo_protocol as wire
from halo_protocol.osc import padded
from halo_service.app.service.serve import _monitor
from halo_service.outputs.settings import ControlSettings, OscSettings
from halo_service.settings import Settings

Spawn = Callable[..., "subprocess.Popen[str]"]
SIM = "sim:demo?mode=NFOV_2X2BINNED"
"""A quarter of the pixels: the service is as before, and the camera costs less."""
HELD = "sim:hand,mode=NFOV_2X2BINNED,drop=0"
"""A finger that rests where the last message put it."""
START_S = 30.0
"""Patience with a busy machine; what is fast is said by the benchmarks."""

SUBSCRIBER = """
import sys, zenoh, halo_protocol as wire
config = zenoh.Config()
config.insert_json5("mode", '"client"')
config.insert_json5("connect/endpoints", f'["{sys.argv[1]}"]')
config.insert_json5("connect/timeout_ms", "20000")
config.insert_json5("scouting/multicast/enabled", "false")
with zenoh.open(config) as session:
    subscriber = session.declare_subscriber("halo/1/**", zenoh.handlers.RingChannel(64))
    for _ in range(200):
        sample = subscriber.recv()
        print(sample.key_expr, bytes(sample.payload).hex(), flush=True)
"""


def lines_until(
    process: subprocess.Popen[str], wanted: Callable[[str], bool], seconds: float = START_S
) -> list[str]:
    """Read a program's lines until one is wanted; fail when none is in time."""
    assert process.stdout is not None
    seen: list[str] = []
    until = time.monotonic() + seconds
    for line in process.stdout:
        seen.append(line.rstrip("\n"))
        if wanted(seen[-1]):
            return seen
        if time.monotonic() > until:
            break
    pytest.fail(f"not seen in {seconds} s; the last lines were {seen[-5:]}")


@pytest.mark.slow
def test_a_real_recording_reaches_oscdump_and_a_zenoh_subscriber(
    external_program: Callable[[str], str],
    company_data: Path,
    serve: Spawn,
    spawn: Spawn,
    free_port: Callable[[], int],
) -> None:
    osc, zenoh = free_port(), f"tcp/127.0.0.1:{free_port()}"
    dump = spawn(external_program("stdbuf"), "-oL", external_program("oscdump"), str(osc))
    serve(
        "--source", f"recording:{company_data / 'azure_kinect_desk.mkv'}", "--loop",
        "--osc", f"127.0.0.1:{osc}", "--zenoh-listen", zenoh, "--node", "desk",
    )  # fmt: skip
    subscriber = spawn(sys.executable, "-c", SUBSCRIBER, zenoh)

    heard = lines_until(dump, lambda line: "/halo/1/table/alive" in line)
    frame = next(line for line in heard if "/halo/1/table/frame" in line)
    assert re.search(r'ssiiiii "desk" "s[0-9a-f]{8}" \d+ \d+ \d+ 0 \d+$', frame), frame
    assert not any("/pointer" in line for line in heard)

    samples = lines_until(subscriber, lambda line: line.startswith("halo/1/desk/table/frame"))
    key, payload = samples[-1].split()
    (surface, header), (_, alive) = wire.decode(bytes.fromhex(payload))
    assert key == "halo/1/desk/table/frame"
    assert surface == "table"
    assert isinstance(header, wire.Frame)
    assert header.count == 0
    assert alive == wire.Alive(())

    scenes = lines_until(subscriber, lambda line: line.startswith("halo/1/desk/table/scene"))
    ((_, scene),) = wire.decode(bytes.fromhex(scenes[-1].split()[1]))
    assert isinstance(scene, wire.Scene)
    assert scene.source == wire.Source.RECORDING
    assert scene.calibration == wire.Calibration.NONE


@pytest.mark.slow
def test_the_end_of_a_recording_is_a_normal_end(company_data: Path, serve: Spawn) -> None:
    service = serve("--source", f"recording:{company_data / 'azure_kinect_desk.mkv'}", "--no-zenoh")
    _, said = service.communicate(timeout=60.0)
    assert service.returncode == 0
    assert "Traceback" not in said


def test_a_missing_hand_model_is_reported_before_the_service_runs(
    tmp_path: Path, serve: Spawn
) -> None:
    (tmp_path / "halo.toml").write_text('[tracking]\nmodel = "none.task"\n')
    config = ("--config", str(tmp_path / "halo.toml"))
    service = serve("--source", SIM, "--no-zenoh", "--no-osc", *config)
    _, said = service.communicate(timeout=60.0)
    assert service.returncode == 2
    assert "tracking.model: none.task does not exist" in said
    assert "Ctrl-C ends" not in said


@pytest.mark.slow
def test_without_a_camera_hover_touch_and_pressure_reach_oscdump(
    external_program: Callable[[str], str], serve: Spawn, spawn: Spawn, free_port: Callable[[], int]
) -> None:
    osc = free_port()
    dump = spawn(external_program("stdbuf"), "-oL", external_program("oscdump"), str(osc))
    service = serve("--osc", f"127.0.0.1:{osc}", "--no-zenoh")
    pointers: list[list[str]] = []

    def complete(line: str) -> bool:
        if "/halo/1/table/pointer" in line:
            pointers.append(line.split("pointer")[1].split()[1:])
        states = {pointer[4] for pointer in pointers}
        pressed = any(float(pointer[10]) > 0.3 for pointer in pointers)
        hovered = any(float(pointer[9]) > 5.0 for pointer in pointers)
        return states == {"0", "1"} and pressed and hovered and len(pointers) > 90

    heard = lines_until(dump, complete, 60.0)
    assert any("/halo/1/table/down" in line for line in heard)
    service.send_signal(signal.SIGTERM)
    _, said = service.communicate(timeout=20.0)
    assert service.returncode == 0
    assert "VIRTUAL" in said
    assert "Traceback" not in said


def finger(height_mm: float, force_g: float) -> bytes:
    """A message that puts the index finger of the right hand somewhere above the middle."""
    values = struct.pack(">iiffff", 2, 1, 150.0, 100.0, height_mm, force_g)
    return padded("/halo/1/sim/finger") + padded(",iiffff") + values


@pytest.mark.slow
def test_a_service_killed_in_mid_touch_leaves_no_pointer_stuck(
    serve: Spawn, free_port: Callable[[], int]
) -> None:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as client:
        client.bind(("127.0.0.1", 0))
        client.settimeout(START_S)
        options = ["--osc", f"127.0.0.1:{client.getsockname()[1]}", "--no-zenoh", "--source", HELD]
        assembler = wire.Assembler()
        sessions: dict[str, list[wire.TouchFrame]] = {}

        def touched() -> tuple[subprocess.Popen[str], list[wire.TouchFrame]]:
            """Start a service, and tap until it reports a touch, which goes on."""
            control, earlier = free_port(), set(sessions)
            service = serve(*options, "--control-port", str(control))
            frames: list[wire.TouchFrame] = []
            until_s = time.monotonic() + 2.0 * START_S
            while not any(pointer.touching for frame in frames[-1:] for pointer in frame.pointers):
                assert time.monotonic() < until_s, frames[-3:]
                tap = finger(25.0, 0.0) if len(frames) % 60 < 30 else finger(0.0, 100.0)
                client.sendto(tap, ("127.0.0.1", control))
                for event in assembler.receive_data(client.recv(65_536), time.monotonic()):
                    if isinstance(event, wire.TouchFrame):
                        sessions.setdefault(event.session, []).append(event)
                frames = [each for new in set(sessions) - earlier for each in sessions[new]]
            return service, frames

        first, _ = touched()
        first.kill()
        first.wait()
        (old,) = sessions.values()
        _, again = touched()
    before, closing = old[-2:]
    assert closing.pointers == ()
    assert [up.id for up in closing.ups] == [each.id for each in before.pointers if each.touching]
    assert closing.ups
    assert again[0].frame > closing.frame  # a client that only compares counters goes on, too


@pytest.mark.parametrize(
    ("osc", "web_url", "control", "command"),
    [
        (OscSettings(), "ws://127.0.0.1:4258/halo", "127.0.0.1", "halo monitor"),
        (OscSettings(enabled=False), "ws://w:1/halo", "127.0.0.1", "halo monitor --from ws://w:1/halo"),
        (OscSettings(enabled=False), "", "0.0.0.0", 'halo monitor --from "osc://?hello=127.0.0.1:9"'),
        (OscSettings(enabled=False), "", "::1", 'halo monitor --from "osc://?hello=[::1]:9"'),
    ],
)  # fmt: skip
def test_the_next_command_shows_what_is_sent(
    osc: OscSettings, web_url: str, control: str, command: str
) -> None:
    settings = Settings(osc=osc, control=ControlSettings(host=control))
    assert _monitor(settings, web_url, 9) == command
