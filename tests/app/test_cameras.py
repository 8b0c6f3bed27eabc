"""`halo cameras`: what is plugged in, on a fake tree of /sys, and what `auto` makes of it."""

from __future__ import annotations

import json
import sys
from pathlib import Path

import pytest

from halo_service.app.cameras import found as cameras
from halo_service.app.cameras.found import FoundCamera, SdkCameras, chosen, merge
from halo_service.app.cameras.udev import fix, rules_text
from halo_service.app.cli import main
from halo_service.app.sources import open_source
from halo_service.errors import UserError
from halo_service.settings import SourceSettings
from halo_service.sources.usb import UsbCamera, usb_cameras

linux = pytest.mark.skipif(sys.platform != "linux", reason="only Linux has /sys")


class Tree:
    """A folder like /sys/bus/usb/devices, and one like /dev/bus/usb."""

    def __init__(self, folder: Path) -> None:
        self.sysfs, self.devices = folder / "sys", folder / "dev"
        self.sysfs.mkdir()
        self.count = 0

    def plug(self, vendor: str, number: str, mode: int = 0o666, **facts: str) -> None:
        self.count += 1
        device = self.sysfs / f"2-{self.count}"
        device.mkdir()
        given = {"idVendor": vendor, "idProduct": number, "speed": "5000", "busnum": "2"}
        for name, text in (given | {"devnum": str(self.count)} | facts).items():
            (device / name).write_text(text + "\n")
        node = self.devices / "002" / f"{self.count:03}"
        node.parent.mkdir(parents=True, exist_ok=True)
        node.touch()
        node.chmod(mode)

    def found(self) -> list[UsbCamera]:
        return usb_cameras(self.sysfs, self.devices)


@pytest.fixture
def tree(tmp_path: Path) -> Tree:
    found = Tree(tmp_path)
    (found.sysfs / "usb1").mkdir()  # a hub that reports nothing
    (found.sysfs / "1-1:1.0").mkdir()  # an interface
    found.plug("046d", "085e", product="a webcam")
    return found


@linux
def test_cameras_are_found_by_their_usb_numbers(tree: Tree) -> None:
    tree.plug("045e", "097a")  # the Kinect's own hub
    tree.plug("045e", "097c", serial="000123")
    tree.plug("2bc5", "066b", serial="CL8", speed="480")
    tree.plug("2bc5", "0669", serial="CM1\x07", mode=0o000)
    tree.plug("2bc5", "0800", product="Orbbec Gemini 335")
    assert [(each.title, each.kind, each.serial, each.is_slow) for each in tree.found()] == [
        ("Azure Kinect", "azure-kinect", "000123", False),
        ("Femto Bolt", "femto-bolt", "CL8", True),
        ("Femto Mega", "femto-mega", "CM1", False),
        ("Orbbec Gemini 335", None, "", False),
    ]


@linux
def test_a_tree_that_is_not_there_or_breaks_shows_nothing(tmp_path: Path, tree: Tree) -> None:
    assert usb_cameras(tmp_path / "nowhere") == []
    tree.plug("2bc5", "066b", speed="fast", busnum="", devnum="x")
    (found,) = tree.found()
    assert (found.speed_mbit, found.serial) == (0, "")


def usb(kind: str | None = "femto-bolt", serial: str = "CL8", speed: int = 5000) -> UsbCamera:
    title = "Femto Bolt" if kind else "Orbbec Gemini 335"
    return UsbCamera(title, kind, serial, speed, Path("/dev/null"))  # type: ignore[arg-type]


FAULTS = {
    "no extra": (usb(), SdkCameras(has_orbbec=False), "but the extra is missing: uv sync --extra"),
    "no Kinect SDK": (
        UsbCamera("Azure Kinect", "azure-kinect", "000123", 5000, Path("/dev/null")),
        SdkCameras(has_kinect=False),
        "its SDK exists only for Linux and Windows on x86-64",
    ),
    "USB 2": (usb(speed=480), SdkCameras(), "is on USB 2: plug it into a USB 3 port"),
    "wrong model": (usb(None), SdkCameras(), "without the sensor that halo-service needs"),
    "fine": (usb(), SdkCameras(femtos=(("femto-bolt", "Orbbec FemtoBolt", "CL8"),)), ""),
}


@pytest.mark.parametrize(("camera", "sdks", "says"), FAULTS.values(), ids=FAULTS)
def test_what_a_camera_lacks_is_named_with_the_remedy(camera, sdks, says) -> None:
    (found,) = merge([camera], sdks)
    assert says in found.fault
    assert bool(found.fault) == bool(says)


def test_a_camera_that_this_user_may_not_open_names_the_fix(tmp_path: Path) -> None:
    missing = UsbCamera("Femto Bolt", "femto-bolt", "CL8", 5000, tmp_path / "no-such-node")
    (found,) = merge([missing], SdkCameras())
    assert found.fault.endswith("this user may not open it: halo doctor --fix")


def test_a_camera_that_both_see_is_listed_once() -> None:
    for serial in ("CL8", ""):
        sdks = SdkCameras(kinects=0, femtos=(("femto-bolt", "Orbbec FemtoBolt", serial),))
        assert len(merge([usb()], sdks)) == 1


def test_what_only_an_sdk_sees_is_listed_too() -> None:
    femtos = (("femto-mega", "Orbbec Femto Mega", "CM1"), (None, "Orbbec Gemini 335", "G"))
    found = merge([], SdkCameras(kinects=2, femtos=femtos))
    assert [(each.kind, each.serial) for each in found] == [
        ("femto-mega", "CM1"), (None, "G"), ("azure-kinect", ""), ("azure-kinect", ""),
    ]  # fmt: skip
    assert found[0].source == "--source femto-mega,serial=CM1"


BOLT = FoundCamera("Femto Bolt", "femto-bolt", "CL8")
KINECT = FoundCamera("Azure Kinect", "azure-kinect", "000123")
BROKEN = FoundCamera("Femto Bolt", "femto-bolt", "CL8", "an Orbbec camera is there, but ...")


def test_auto_uses_the_camera_of_the_profile_else_the_first() -> None:
    assert chosen([]) is None
    for found, serial, kind in [
        ([KINECT, BOLT], "", "azure-kinect"),
        ([KINECT, BOLT], "CL8", "femto-bolt"),
        ([BROKEN, KINECT], "", "azure-kinect"),
    ]:
        choice = chosen(found, serial)
        assert choice is not None
        assert choice.kind == kind
        assert choice.title == ("Femto Bolt CL8" if kind == "femto-bolt" else "Azure Kinect 000123")


def test_auto_never_uses_the_virtual_camera_while_a_camera_is_plugged_in(monkeypatch) -> None:
    monkeypatch.setattr(cameras, "found_cameras", lambda: [BROKEN])
    with pytest.raises(UserError, match=r"an Orbbec camera is there, .*--source sim"):
        open_source(SourceSettings("auto"))


def test_any_camera_is_never_the_virtual_one(monkeypatch) -> None:
    monkeypatch.setattr(cameras, "found_cameras", list)
    with pytest.raises(UserError, match=r"no camera is plugged in.*halo cameras"):
        open_source(SourceSettings("camera"))


def test_the_command_lists_them(monkeypatch, capsys) -> None:
    monkeypatch.setattr(cameras, "found_cameras", lambda: [BOLT, BROKEN])
    assert main(["cameras"]) == 0
    assert capsys.readouterr().out.splitlines() == [
        "Femto Bolt CL8: --source femto-bolt,serial=CL8",
        "Femto Bolt CL8: an Orbbec camera is there, but ...",
    ]
    assert main(["cameras", "--json"]) == 0
    assert json.loads(capsys.readouterr().out.splitlines()[0]) == {
        "title": "Femto Bolt",
        "kind": "femto-bolt",
        "serial": "CL8",
        "source": "--source femto-bolt,serial=CL8",
        "fault": "",
    }
    monkeypatch.setattr(cameras, "found_cameras", list)
    assert main(["cameras"]) == 1
    assert "no camera found" in capsys.readouterr().out


def test_the_rule_is_shown_before_it_is_written(tmp_path: Path) -> None:
    rules, shown = tmp_path / "99-halo.rules", []

    def answer(yes: bool):
        return lambda question: shown.append(question) or yes

    assert fix(answer(False), rules, "linux") == "permissions: nothing was changed"
    assert not rules.exists()
    assert rules_text() in shown[0]
    assert "plug the camera out and in" in fix(answer(True), rules, "linux")
    assert rules.read_text() == rules_text()
    assert "is there already" in fix(answer(True), rules, "linux")
    assert len(shown) == 2
    assert "only Linux" in fix(answer(True), rules, "win32")
    with pytest.raises(UserError, match=r"cannot be written .*sudo"):
        fix(answer(True), tmp_path / "nowhere" / "x.rules", "linux")


def test_the_rule_has_every_vendor() -> None:
    lines = [line for line in rules_text().splitlines() if not line.startswith("#")]
    assert all(line.startswith('SUBSYSTEM=="usb", ATTR{idVendor}=="') for line in lines)
    assert {line.split('"')[3] for line in lines} == {"045e", "2bc5"}
