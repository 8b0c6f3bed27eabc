"""What the page can do, without a browser: settings, profiles, outputs, recordings."""

from __future__ import annotations

import socket
import time
from collections.abc import Callable, Iterator
from contextlib import closing
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import halo_protocol as wire
from halo_service.app.page import camera_calls
from halo_service.app.page.camera_calls import CameraCalls
from halo_service.app.page.observer import PATTERN_ID, PageObserver
from halo_service.app.page.output_calls import OutputCalls
from halo_service.app.page.profile_calls import ProfileCalls
from halo_service.app.page.record_calls import RecordCalls
from halo_service.app.page.settings_calls import SettingsCalls
from halo_service.app.service.profile_reloader import ProfileReloader
from halo_service.errors import UserError
from halo_service.geometry.camera import Camera
from halo_service.outputs.destination import parse_destination
from halo_service.outputs.osc import OscOutput
from halo_service.profile.store import profile_path, save
from halo_service.runtime.health import Health
from halo_service.sensing import SensingSettings, State, start
from halo_service.settings import Settings, load
from halo_service.sources.recording import Recording
from halo_service.sources.switched import SwitchedSource
from halo_service.sources.usb import UsbCamera
from halo_service.values import Frame, TouchFrame
from halo_service.web.control_page.server import PageServer
from halo_service.web.settings import PageSettings
from tests.app.page.test_pictures import CAMERA, SHAPE, profile


class Noted:
    """A publisher that remembers."""

    def __init__(self) -> None:
        self.frames: list[TouchFrame] = []

    def frame(self, touch_frame: TouchFrame) -> None:
        self.frames.append(touch_frame)

    def scene(self, state: State) -> None:
        """Nothing."""

    def health(self, health: Health) -> None:
        """Nothing."""


@pytest.fixture
def server(free_port: Callable[[], int]) -> Iterator[PageServer]:
    with closing(PageServer(PageSettings(port=free_port()))) as server:
        yield server


@pytest.fixture
def observer(server: PageServer) -> Iterator[PageObserver]:
    with closing(PageObserver(Noted(), server, CAMERA, lambda: "good", dict)) as observer:
        yield observer


@pytest.fixture
def receiver() -> Iterator[socket.socket]:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as receiver:
        receiver.bind(("127.0.0.1", 0))
        receiver.settimeout(10.0)
        yield receiver


def place(receiver: socket.socket) -> str:
    return f"127.0.0.1:{receiver.getsockname()[1]}"


def empty(n: int) -> TouchFrame:
    return TouchFrame(1_000_000 + n * 33_333, "table", 300.0, 200.0)


def run(calls: Any, call: str, /, **request: Any) -> Any:
    return calls.table()[call].run(request)


def test_the_pattern_replaces_touches_until_it_is_stopped(observer: PageObserver) -> None:
    noted: Any = observer._inner
    observer.turn(start(profile(), SensingSettings()))
    for n in range(4):
        if n == 1:
            observer.start_pattern()
        if n == 3:
            observer.stop_pattern()
        observer.frame(empty(n))
    assert [len(frame.pointers) for frame in noted.frames] == [0, 1, 1, 0]
    pattern = noted.frames[1]
    assert (pattern.surface, pattern.width_mm, pattern.time_us) == ("table", 200.0, 1_033_333)
    assert pattern.pointers[0].id == PATTERN_ID + 1
    assert [event.kind for event in pattern.events] == ["down"]
    observer.start_pattern()
    observer.frame(empty(5))
    assert noted.frames[-1].pointers[0].id == PATTERN_ID + 2


def test_settings_are_written_and_used_at_once(
    tmp_path: Path, observer: PageObserver, receiver: socket.socket
) -> None:
    path = tmp_path / "halo.toml"
    path.write_text("# mine\n")
    with closing(OscOutput([parse_destination("127.0.0.1:9")])) as osc:
        calls = SettingsCalls(Settings(), path, osc, observer.request)
        changes = [
            {"section": "sensing", "key": "hover_range_mm", "value": 60.0},
            {"section": "osc", "key": "destinations", "value": [place(receiver)]},
            {"section": "web", "key": "port", "value": 4999},
        ]
        done = run(calls, "change-settings", changes=changes)
        assert done["later"] == ["web"]
        state = observer.turn(start(None, SensingSettings()))
        assert state.settings.hover_range_mm == 60.0
        assert [str(each.destination) for each in osc.senders] == [f"{place(receiver)}/frames"]
        read = run(calls, "settings")
    assert path.read_text().startswith("# mine\n")
    assert load(path).web.port == 4999
    assert read["values"]["sensing"]["hover_range_mm"] == 60.0
    assert read["defaults"]["sensing"]["hover_range_mm"] == 100.0
    assert (
        read["schema"]["$defs"]["SensingSettings"]["properties"]["hover_range_mm"]["unit"] == "mm"
    )


def test_the_token_is_not_shown(tmp_path: Path, observer: PageObserver) -> None:
    path = tmp_path / "halo.toml"
    path.write_text('[page]\ntoken = "abcdefghijklmnop"\n')
    with closing(OscOutput([])) as osc:
        read = run(SettingsCalls(load(path), path, osc, observer.request), "settings")
    assert "abcdefghijklmnop" not in str(read)


@pytest.fixture
def profiles() -> Iterator[ProfileCalls]:
    save(profile(), profile_path("desk"))
    with closing(ProfileReloader(None, CAMERA, None)) as reloader:
        yield ProfileCalls(reloader, lambda: "used")


def names(calls: ProfileCalls) -> set[str]:
    return {each["name"] for each in run(calls, "profiles")["profiles"]}


def test_profiles_are_copied_exported_imported_and_deleted(profiles: ProfileCalls) -> None:
    run(profiles, "copy-profile", name="desk", to="hall")
    exported = run(profiles, "export-profile", name="hall")
    run(profiles, "rename-profile", name="hall", to="stage")
    assert {"desk", "stage"} <= names(profiles) and "hall" not in names(profiles)
    assert profiles.table()["import-profile"].run(exported) == {"name": "hall"}
    assert profiles.table()["import-profile"].run(exported) == {"name": "hall-2"}
    for name in ("hall", "hall-2", "stage"):
        run(profiles, "delete-profile", name=name)
    assert {"hall", "hall-2", "stage"}.isdisjoint(names(profiles))


FOLDERS: list[tuple[str, dict[str, Any]]] = [
    ("copy-profile", {"name": "../desk", "to": "a"}),
    ("copy-profile", {"name": "desk", "to": "/tmp/a"}),
    ("rename-profile", {"name": "desk", "to": "../a"}),
    ("delete-profile", {"name": "/etc"}),
    ("delete-profile", {"name": "used"}),
    ("export-profile", {"name": "..\\desk"}),
    ("use-profile", {"name": ["desk"]}),
    ("use-profile", {"name": "nothing"}),
    ("copy-profile", {"name": "desk", "to": "desk"}),
]


def test_a_request_cannot_choose_a_folder(profiles: ProfileCalls) -> None:
    before = names(profiles)
    for call, request in FOLDERS:
        with pytest.raises(UserError):
            run(profiles, call, **request)
    assert names(profiles) == before


def test_a_file_that_is_no_profile_is_refused(profiles: ProfileCalls) -> None:
    with pytest.raises(UserError) as refused:
        profiles.table()["import-profile"].run(b"PK nothing")
    assert "/tmp" not in str(refused.value)


def test_a_test_pattern_reaches_one_destination(
    observer: PageObserver, receiver: socket.socket
) -> None:
    with closing(OscOutput([])) as osc:
        calls = OutputCalls(Settings(node="desk"), osc, None, (), observer)
        run(calls, "start-pattern", to=place(receiver))
        seen: list[wire.Message] = []
        while not any(isinstance(each, wire.Pointer) for each in seen):
            seen += [message for _, message in wire.decode(receiver.recv(65_536))]
        assert run(calls, "outputs")["patterns"] == [place(receiver)]
        run(calls, "stop-pattern", to=place(receiver))
        assert run(calls, "outputs")["patterns"] == []
        with pytest.raises(UserError):
            run(calls, "start-pattern", to="nonsense")
    assert {each.node for each in seen if isinstance(each, wire.Frame)} == {"desk-test"}


class Silent:
    """A camera that shows nothing now."""

    kind = "camera"
    closed = False

    def __init__(self, camera: Camera = CAMERA) -> None:
        self.camera = camera

    def read(self, timeout_s: float) -> Frame | None:
        return None

    def close(self) -> None:
        self.closed = True


def test_a_recording_holds_the_frames_of_the_service_and_is_replayed_in_its_place(
    observer: PageObserver,
) -> None:
    camera = Silent()
    source = SwitchedSource(camera)  # type: ignore[arg-type]
    step = ""
    calls = RecordCalls(source, observer, lambda: step)
    path = Path(run(calls, "start-recording")["path"])
    with pytest.raises(UserError, match="runs already"):
        run(calls, "start-recording")
    depth = np.full(SHAPE, 500, np.uint16)
    for n in range(3):
        observer.watch(Frame(1_700_000_000_000_000 + n * 33_333, depth + n, depth))
    time.sleep(0.3)
    assert run(calls, "stop-recording")["result"] == "3 frames"
    assert [each["path"] for each in run(calls, "recordings")["recordings"]] == [str(path)]
    with closing(Recording(path, realtime=False, loop=False)) as recording:
        assert [int(recording.read(1.0).depth[0, 0]) for _ in range(3)] == [500, 501, 502]  # type: ignore[union-attr]
    step = "touch"
    with pytest.raises(UserError, match="'touch' of the set-up runs"):
        run(calls, "replay", name=path.name)
    step = ""
    for name in (str(path), f"../recordings/{path.name}", "", 7, None):
        with pytest.raises(UserError, match="no such recording"):
            run(calls, "replay", name=name)
    run(calls, "replay", name=path.name)
    seen = [source.read(1.0) for _ in range(5)]
    assert [int(each.depth[0, 0]) for each in seen] == [500, 501, 502, 500, 501]  # type: ignore[union-attr]
    assert (source.kind, run(calls, "recordings")["replayed"]) == ("recording", path.name)
    with pytest.raises(UserError, match="stop the replay"):
        run(calls, "start-recording")
    run(calls, "stop-replay")
    assert source.read(0.0) is None
    assert (source.kind, run(calls, "recordings")["replayed"]) == ("camera", "")
    other = SwitchedSource(Silent(replace(CAMERA, serial="another")))  # type: ignore[arg-type]
    with pytest.raises(UserError, match="and the service uses another"):
        run(RecordCalls(other, observer, str), "replay", name=path.name)
    source.close()
    assert camera.closed


def test_cameras_that_are_plugged_in_are_listed(monkeypatch: pytest.MonkeyPatch) -> None:
    bolt = UsbCamera("Femto Bolt", "femto-bolt", "CL8", 480, Path("/dev/null"))
    monkeypatch.setattr(camera_calls, "usb_cameras", lambda: [bolt])
    monkeypatch.setattr(camera_calls.sys, "platform", "linux")
    (found,) = run(CameraCalls(), "cameras")["cameras"]
    assert (found["serial"], found["source"]) == ("CL8", "--source femto-bolt,serial=CL8")
