"""The doctor names what is missing, with its remedy."""

from __future__ import annotations

import socket
import threading
from dataclasses import replace
from pathlib import Path

import pytest

from halo_service.app.cli import main
from halo_service.app.doctor import Finding, _control, examine, format_finding
from halo_service.app.service.commands import status
from halo_service.outputs.settings import ControlSettings, ZenohSettings
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


def test_optional_parts_that_are_absent_are_none_and_not_missing() -> None:
    found = findings(Settings())
    assert format_finding(found["profile"]).startswith("none    profile: none chosen")
    assert found["profile"].optional
    camera = found["camera"]
    assert camera.good or camera.optional, "without a camera, auto uses the virtual one"


def test_the_doctor_exits_with_1_when_something_is_missing(
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert main(["doctor", "--profile", "./nowhere"]) == 1
    assert "MISSING profile: there is no profile at" in capsys.readouterr().out


def test_a_control_port_that_our_own_service_has_is_no_fault() -> None:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as service:
        service.bind(("127.0.0.1", 0))
        service.settimeout(10.0)
        port = service.getsockname()[1]

        def answer() -> None:
            question, asker = service.recvfrom(4096)
            reply = status("desk", "s1", "", "", paused=False)
            assert len(reply) <= len(question)
            service.sendto(reply, asker)

        answering = threading.Thread(target=answer)
        answering.start()
        found = _control(replace(Settings(), control=ControlSettings(port=port)))
        answering.join()
    assert (found.good, found.state) == (True, f"a halo service runs at 127.0.0.1:{port}")
