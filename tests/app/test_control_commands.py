"""Commands on the control port: each does one thing, for allowed hosts alone."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import closing
from dataclasses import dataclass, field, replace
from pathlib import Path
from threading import Event

import pytest

import halo_protocol as wire
from halo_service.app.service.commands import SETTINGS
from halo_service.app.service.control_handler import ControlHandler
from halo_service.app.service.profile_reloader import ProfileReloader
from halo_service.errors import UserError
from halo_service.outputs.control import ControlMessage, ControlPort
from halo_service.outputs.leases import Leases
from halo_service.outputs.osc import OscOutput
from halo_service.profile.store import save
from halo_service.sensing import SensingSettings, State, start
from tests.app.test_profile_reloader import profile, refreshed  # noqa: F401 - a fixture

CONTROL = "/halo/1/control/"


@dataclass
class Service:
    control: ControlPort
    handler: ControlHandler
    reloader: ProfileReloader
    paused: Event
    state: State
    answers: list[bytes] = field(default_factory=list)

    def get(
        self, address: str, *arguments: wire.Argument, host: str = "127.0.0.1", size: int = 256
    ) -> None:
        """Receive one message and handle it."""
        message = ControlMessage(CONTROL + address, arguments, (host, 9), size, self.answers.append)
        self.control.put(message)
        self.state = self.handler.handle(self.state, None)

    def status(self) -> tuple[wire.Argument, ...]:
        self.answers.clear()
        self.get("status", " " * 220)
        ((address, arguments),) = wire.parse_osc(self.answers[0])
        assert address == CONTROL + "status"
        return arguments


@pytest.fixture
def service(
    profile,  # noqa: F811
    tmp_path: Path,
    free_port: Callable[[], int],
    monkeypatch: pytest.MonkeyPatch,
) -> Iterator[Service]:
    monkeypatch.setattr("halo_service.app.service.commands.profile_path", tmp_path.joinpath)
    # Both threads look rarely whether they should end, and are ended here 34 times.
    monkeypatch.setattr("halo_service.app.service.profile_reloader.LOOK_S", 0.02)
    monkeypatch.setattr("halo_service.outputs.control.WAKE_S", 0.02)
    for name, camera in (("desk", "A1"), ("lamp", "A1"), ("other", "B2")):
        made_with = replace(profile.camera, serial=camera)
        save(replace(profile, name=name, camera=made_with), tmp_path / name)
    with (
        closing(ControlPort("127.0.0.1", free_port())) as control,
        closing(OscOutput([])) as osc,
        closing(ProfileReloader(tmp_path / "desk", profile.camera, profile)) as reloader,
    ):
        paused = Event()
        leases = Leases("desk", "s1", ("127.0.0.0/8",))
        handler = ControlHandler(control, reloader, leases, osc, paused)
        yield Service(control, handler, reloader, paused, start(profile, SensingSettings()))


PRESSES: list[tuple[wire.Argument, ...]] = [(), (1,), (1.0,), (0.5,), ("bang",), (True,), (None,)]


@pytest.mark.parametrize("arguments", PRESSES)
def test_any_message_is_one_action(
    service: Service, arguments: tuple[wire.Argument, ...], monkeypatch: pytest.MonkeyPatch
) -> None:
    retaken: list[None] = []
    monkeypatch.setitem(
        service.handler._triggers, CONTROL + "background", lambda: retaken.append(None)
    )
    service.get("background", *arguments)
    assert len(retaken) == 1


@pytest.mark.parametrize("release", [0, 0.0, False])
def test_a_button_that_sends_1_and_0_triggers_once(
    service: Service, release: wire.Argument, monkeypatch: pytest.MonkeyPatch
) -> None:
    retaken: list[None] = []
    monkeypatch.setitem(
        service.handler._triggers, CONTROL + "background", lambda: retaken.append(None)
    )
    service.get("background", 1)
    service.get("background", release)
    assert len(retaken) == 1
    service.get("pause", release)
    assert not service.paused.is_set()


def test_pause_and_resume(service: Service) -> None:
    service.get("pause", 1.0)
    assert service.paused.is_set()
    assert service.status()[3:] == ("desk", "", 1)
    service.get("resume")
    assert not service.paused.is_set()
    assert service.status() == ("desk", "s1", wire.VERSION, "desk", "", 0)


def test_the_status_is_not_larger_than_its_question(service: Service) -> None:
    service.handler._error = "x" * 999
    service.status()
    assert len(service.answers[0]) <= 256
    service.answers.clear()
    service.get("status", size=252)
    assert service.answers == []


def test_a_profile_is_switched_and_the_hand_tracker_made_again(service: Service) -> None:
    remade: list[None] = []
    service.reloader.on_change = lambda: remade.append(None)
    service.get("profile", "lamp")
    service.state = refreshed(service.reloader, service.state, lambda p: p.name == "lamp")
    assert len(remade) == 1
    assert service.status()[3:5] == ("lamp", "")


@pytest.mark.parametrize(
    ("name", "why"),
    [("none", "there is no profile at"), ("other", "the profile 'other' belongs to camera")],
)
def test_a_profile_that_does_not_fit_leaves_the_old_one(
    service: Service, name: str, why: str
) -> None:
    service.get("profile", name)
    for _ in range(100):
        if service.reloader.error:
            break
        Event().wait(0.05)
    assert str(service.status()[4]).startswith(why)
    assert service.status()[3] == "desk"


@pytest.mark.parametrize("arguments", [(), (1,), ("../desk",), ("/etc",), ("a/b",), ("..",), ("",)])
def test_a_client_names_profiles_of_the_data_folder_alone(
    service: Service, arguments: tuple[wire.Argument, ...]
) -> None:
    service.get("profile", *arguments)
    assert str(service.status()[4]).startswith("send the name of a profile")


def test_a_setting_changes_at_once(service: Service) -> None:
    service.get("sensing/hover_range_mm", 60)
    service.get("sensing/up_level", 0.10000000149)  # as a float32 holds it
    service.get("sensing/fingers", "all")
    settings = service.state.settings
    assert (settings.hover_range_mm, settings.up_level, settings.fingers) == (60.0, 0.1, "all")
    assert service.status()[4] == ""


@pytest.mark.parametrize(
    ("name", "value", "why"),
    [
        ("hover_range_mm", -1.0, "'hover_range_mm' must be more than 0"),
        ("hover_range_mm", "far", "'hover_range_mm' must be a number"),
        ("fingers", "toes", "'fingers' must be"),
        ("up_level", 0.9, "'up_level' must be below 'down_level'"),
        ("node", "x", "unknown setting"),
        ("hover_range_mm", True, "send the value as a number or text"),
    ],
)
def test_a_value_that_is_not_allowed_changes_nothing(
    service: Service, name: str, value: wire.Argument, why: str
) -> None:
    before = service.state.settings
    service.get(f"sensing/{name}", value)
    assert service.state.settings == before
    assert why in str(service.status()[4])


def test_other_hosts_are_not_heard(service: Service, caplog: pytest.LogCaptureFixture) -> None:
    for address in ("pause", "background", "status", "profile", "sensing/hover_range_mm", "hello"):
        service.get(address, 50.0, host="192.0.2.7")
    assert not service.paused.is_set()
    assert service.state.settings == SensingSettings()
    assert service.answers == []
    assert "its host is not in [control] networks" in caplog.text


def test_a_network_that_cannot_be_read_is_one_sentence() -> None:
    with pytest.raises(UserError, match="'home' is not a network"):
        Leases("desk", "s1", ["home"])


def test_oscquery_lists_each_address_that_is_handled(service: Service) -> None:
    service.handler.handle(service.state, None)
    listed = {node.path for node in service.handler.nodes()}
    assert set(service.handler._rows) - listed == {"/halo/1/sim/finger"}, "no virtual camera here"
    settings = {path for path in listed if "/sensing/" in path}
    assert {path.rpartition("/")[2] for path in settings} == set(SETTINGS)
