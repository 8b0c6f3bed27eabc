"""A grid is touched, by the virtual user and by whoever a running service sees."""

from __future__ import annotations

import signal
import socket
import subprocess
import sys
import threading
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import halo_protocol as wire
from halo_service.app.cli import main
from halo_service.app.virtual_user.cache import cached_profile
from halo_service.app.virtual_user.profile import virtual_profile
from halo_service.geometry.surface import Surface
from halo_service.profile import Projector
from halo_service.profile.store import load, save
from halo_service.settings import Settings
from halo_service.virtual.sim_url import parse_sim_url
from tests.kind_sensor import KIND_URL

SIM = f"sim:idle?seed=202&material=paper&mode=NFOV_2X2BINNED&{KIND_URL}"
"""A quarter of the pixels: drawn in half the time."""


@pytest.fixture(autouse=True)
def no_screen(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("SDL_VIDEODRIVER", "dummy")


@pytest.fixture(scope="module")
def small(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A calibrated profile of a few centimetres: four crossings, so that a test is short."""
    room = parse_sim_url(SIM).room
    profile = cached_profile(room, Settings(), virtual_profile)
    corner = np.eye(4)
    corner[:3, 3] = (120.0, 80.0, 0.0)
    surface = Surface("table", 60.0, 60.0, profile.surface.camera_from_surface @ corner)
    truth = room.projector.projector_from_surface() @ corner[np.ix_((0, 1, 3), (0, 1, 3))]
    size = room.projector.width_px, room.projector.height_px
    placed = replace(profile, surface=surface, projector=Projector(*size, truth / truth[2, 2]))
    folder = tmp_path_factory.mktemp("verify") / "small"
    save(placed, folder)
    return folder


@pytest.mark.slow
def test_the_virtual_user_touches_what_is_projected(
    small: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    arguments = ["verify", "--source", SIM, "--profile", str(small)]
    assert main([*arguments, "--within-mm", "12"]) == 0
    said = capsys.readouterr()
    assert "of 4 of 4 crossings: median" in said.out
    assert "passed: touch all crossings, 95 % within 12 mm" in said.out
    assert "row 2 from the far edge, column 2" in said.err


def test_a_profile_without_a_projector_says_what_to_do(
    small: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    bare = tmp_path / "bare"
    save(replace(load(small), projector=None), bare)
    assert main(["verify", "--source", SIM, "--profile", str(bare)]) == 2
    assert "has no projector: run 'halo calibrate projector'" in capsys.readouterr().err


def test_without_a_profile_there_is_no_grid(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["verify", "--source", SIM]) == 2
    assert "name a profile" in capsys.readouterr().err


def stopped(process: subprocess.Popen[str], after: str) -> tuple[int, str]:
    """Press Ctrl-C once a line with these words was printed; return the exit code and the output
    from then on."""
    assert process.stderr is not None
    assert any(after in line for line in process.stderr)
    process.send_signal(signal.SIGINT)
    out, err = process.communicate(timeout=60.0)
    return process.returncode, out + err


@pytest.mark.slow
def test_ctrl_c_ends_a_verification_with_its_figures(
    small: Path, spawn: Callable[..., subprocess.Popen[str]]
) -> None:
    process = spawn(
        Path(sys.executable).with_name("halo"), "verify", "--source", SIM, "--profile", small
    )
    code, said = stopped(process, after="mm off")
    assert code == 1
    assert "touches of 1 of 4 crossings" in said or "touches of 2 of 4 crossings" in said


@pytest.mark.slow
@pytest.mark.parametrize("step", ["background", "touch", "projector"])
def test_ctrl_c_in_a_calibration_leaves_the_profile_as_it_was(
    small: Path, spawn: Callable[..., subprocess.Popen[str]], step: str
) -> None:
    before = {path.name: path.read_bytes() for path in small.iterdir()}
    process = spawn(
        Path(sys.executable).with_name("halo"),
        "calibrate",
        step,
        "--source",
        SIM,
        "--profile",
        small,
    )
    code, said = stopped(process, after=f"Calibrating {small}")
    assert code == 130
    assert "stopped before the end; complete results are saved" in said
    assert {path.name: path.read_bytes() for path in small.iterdir()} == before


MATRIX = (3.0, 0.1, 50.0, 0.0, 3.0, 60.0, 0.0, 0.0, 1.0)


@pytest.fixture
def service(free_port: Callable[[], int]) -> Iterator[str]:
    """Somebody who sends a small surface, a projector, and touches of its four crossings."""
    port, ended = free_port(), threading.Event()
    scene = wire.Scene("desk", "s1", wire.VERSION, 60.0, 60.0, 2, 3, 2, 30.0)
    homography = wire.Homography("desk", "s1", 3, 640, 480, MATRIX)
    places = [(x, y) for y in (15.0, 45.0) for x in (15.0, 45.0)]

    def send() -> None:
        number = 0
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as out:
            while not ended.wait(0.02):
                x, y = places[number // 10 % 4]
                u, v = (x + 1.0) / 60.0, (y - 1.0) / 60.0
                touch = wire.Pointer(
                    number, 0, 2, 1, 1, u, v, x + 1.0, y - 1.0, 0.0, 0.5, 0.0, 0.0, 0.9, 1, -1.0
                )
                downs = [wire.Down(number, 0, u, v, 100.0, 5.0, 1)] if number % 10 == 0 else []
                header = wire.Frame("desk", "s1", number, 1, number * 1000, 1)
                sent = [wire.encode("table", scene), wire.encode("table", homography)]
                sent += wire.encode_frame("table", header, [touch], downs, [])
                for datagram in sent:
                    out.sendto(datagram, ("127.0.0.1", port))
                number += 1

    thread = threading.Thread(target=send, daemon=True)
    thread.start()
    yield f"osc://127.0.0.1:{port}"
    ended.set()
    thread.join()


def test_fingers_of_a_running_service_are_compared_with_its_own_grid(
    service: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["verify", "--from", service, "--window"]) == 0
    out = capsys.readouterr().out
    assert "of 4 of 4 crossings: median 1.4 mm" in out


def test_what_is_too_far_off_fails(service: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["verify", "--from", service, "--window", "--within-mm", "1"]) == 1
    assert "failed: touch all crossings, 95 % within" in capsys.readouterr().out


def test_a_service_that_is_not_there_is_a_sentence(
    free_port: Callable[[], int],
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.setattr("halo_service.app.verification.remote.WAIT_S", 0.5)
    assert main(["verify", "--from", f"osc://127.0.0.1:{free_port()}", "--window"]) == 2
    assert "sends nothing: start 'halo serve'" in capsys.readouterr().err
