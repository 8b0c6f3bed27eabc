"""The doctor names what is missing, with its remedy."""

from __future__ import annotations

import socket
import threading
from dataclasses import replace
from pathlib import Path

import pytest

from halo_service.app.cli import main
from halo_service.app.doctor import Finding, control_port, examine, format_finding
from halo_service.app.service.commands import Status
from halo_service.errors import UserError
from halo_service.outputs.settings import ControlSettings, ZenohSettings
from halo_service.profile.store import load
from halo_service.settings import Settings


def findings(settings: Settings) -> dict[str, Finding]:
    return {finding.what: finding for finding in examine(settings)}


def test_every_miss_has_a_remedy(tmp_path: Path) -> None:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as taken:
        taken.bind(("127.0.0.1", 0))
        settings = replace(
            Settings(),
            source=replace(Settings().source, name="azure-kinect"),
            profile=str(tmp_path / "none"),
            control=ControlSettings(port=taken.getsockname()[1]),
            zenoh=ZenohSettings(connect=("tcp/127.0.0.1:1",)),
            tracking=replace(Settings().tracking, model=str(tmp_path / "no.task")),
        )
        found = findings(settings)
    for what in ("camera", "hand model", "profile", "control port", "zenoh"):
        assert not found[what].good, what
        assert ";" in format_finding(found[what]), "what is wrong, and then the remedy"
    assert found["packages"].good
    assert found["control port"].optional, "a service takes a free port"


def test_optional_parts_that_are_absent_are_none_and_not_missing() -> None:
    found = findings(Settings())
    assert format_finding(found["profile"]).startswith("none    profile: none chosen")
    assert found["profile"].optional
    camera = found["camera"]
    assert camera.good or camera.optional, "without a camera, auto uses the virtual one"


@pytest.mark.parametrize(
    ("reason", "package"),
    [
        ("libEGL.so.1: cannot open shared object file: No such file or directory", "libegl1"),
        ("libGLESv2.so.2: cannot open shared object file: No such file", "libgles2"),
    ],
)
def test_a_missing_library_of_the_system_is_found_with_its_package(
    monkeypatch: pytest.MonkeyPatch, reason: str, package: str
) -> None:
    from mediapipe.tasks.python import vision

    def fail(options: object) -> None:
        raise OSError(reason)

    assert findings(Settings())["hand model"].good
    monkeypatch.setattr(vision.HandLandmarker, "create_from_options", fail)
    found = findings(Settings())["hand model"]
    assert not found.good
    assert f"'apt install {package}'" in format_finding(found)
    assert "tracking.model" not in format_finding(found)


def test_a_package_that_cannot_be_loaded_is_found(monkeypatch: pytest.MonkeyPatch) -> None:
    def broken(name: str) -> None:
        if name == "cv2":
            raise ImportError("libstdc++.so.6: version GLIBCXX_3.4.32 not found")

    monkeypatch.setattr("halo_service.app.doctor.importlib.import_module", broken)
    found = findings(Settings())["packages"]
    assert not found.good
    assert "cv2 cannot be loaded (libstdc++" in format_finding(found)


@pytest.mark.parametrize("home", ["", "relative"])
def test_a_user_without_a_home_gets_sentences(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, home: str
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("HOME", home)
    monkeypatch.delenv("XDG_DATA_HOME", raising=False)
    monkeypatch.delenv("XDG_CACHE_HOME", raising=False)
    lines = [format_finding(finding) for finding in examine(replace(Settings(), profile="desk"))]
    assert sum("this user has no home folder; set HOME or XDG_DATA_HOME" in x for x in lines) >= 1
    assert sum("this user has no home folder; set HOME or XDG_CACHE_HOME" in x for x in lines) == 1
    assert main(["profile", "list"]) == 2
    with pytest.raises(UserError, match=r"there is no profile at .*nowhere"):
        load(tmp_path / "nowhere")
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path / "data"))
    assert main(["profile", "list"]) == 0
    assert list(tmp_path.iterdir()) == []


def test_the_doctor_exits_with_1_when_something_is_missing(
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert main(["doctor", "--profile", "./nowhere"]) == 1
    assert "MISSING profile: there is no profile at" in capsys.readouterr().out


def test_acontrol_port_that_our_own_service_has_is_no_fault() -> None:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as service:
        service.bind(("127.0.0.1", 0))
        service.settimeout(10.0)
        port = service.getsockname()[1]

        def answer() -> None:
            question, asker = service.recvfrom(4096)
            reply = Status("desk", "s1", "1.0.0", "", "", paused=0).packed()
            assert len(reply) <= len(question)
            service.sendto(reply, asker)

        answering = threading.Thread(target=answer)
        answering.start()
        found = control_port(replace(Settings(), control=ControlSettings(port=port)))
        answering.join()
    assert (found.good, found.state) == (True, f"a halo service runs at 127.0.0.1:{port}")
