"""Which cameras are plugged in, seen by USB number and by each SDK, and what each lacks."""

from __future__ import annotations

import importlib.util
from collections.abc import Sequence
from dataclasses import dataclass, replace

from halo_service.errors import UserError
from halo_service.evaluation.report.table import Table
from halo_service.sources.camera_name import TITLES, CameraKind
from halo_service.sources.usb import UsbCamera, usb_cameras


@dataclass(frozen=True, slots=True)
class FoundCamera:
    """A camera that is plugged in."""

    title: str
    kind: CameraKind | None
    """None: Orbbec's, of a model without the sensor."""
    serial: str
    """Empty where unknown."""
    fault: str = ""
    """What is wrong, and the remedy; empty: it can be opened, as far as one can see."""

    @property
    def source(self) -> str:
        """The option that opens it; empty where nothing does."""
        if self.kind is None:
            return ""
        return f"--source {self.kind}" + (f",serial={self.serial}" if self.serial else "")

    def as_dict(self) -> dict[str, str]:
        """Return it for programs."""
        return {
            "title": self.title,
            "kind": self.kind or "",
            "serial": self.serial,
            "source": self.source,
            "fault": self.fault,
        }

    def __str__(self) -> str:
        """Return it as one line."""
        what = f"{self.title} {self.serial}".strip()
        return f"{what}: {self.fault or self.source}"


@dataclass(frozen=True, slots=True)
class SdkCameras:
    """What the SDKs see."""

    kinects: int = 0
    femtos: tuple[tuple[CameraKind | None, str, str], ...] = ()
    """Kind, model and serial number of each."""
    has_orbbec: bool = True
    """Whether the extra is installed."""
    has_kinect: bool = True
    """Whether the SDK of the Azure Kinect is installed."""


def found_cameras() -> list[FoundCamera]:
    """List what is plugged in."""
    return merge(usb_cameras(), ask_sdks())


def ask_sdks() -> SdkCameras:
    """Ask both SDKs; one that is not installed sees nothing."""
    from halo_service.sources import azure_kinect
    from halo_service.sources.orbbec import sdk

    femtos = tuple((each.kind, each.name, each.serial) for each in sdk.plugged())
    return replace(installed_sdks(), kinects=azure_kinect.connected(), femtos=femtos)


def installed_sdks() -> SdkCameras:
    """Say which SDKs are installed, and load none."""
    has_orbbec, has_kinect = (
        importlib.util.find_spec(name) is not None for name in ("pyorbbecsdk", "pyk4a")
    )
    return SdkCameras(has_orbbec=has_orbbec, has_kinect=has_kinect)


def merge(usb: Sequence[UsbCamera], sdks: SdkCameras) -> list[FoundCamera]:
    """Join what the USB shows and what the SDKs see. Pure."""
    found = [_on_usb(camera, sdks) for camera in usb]
    listed = {camera.serial for camera in found if camera.serial}
    kinds = {camera.kind for camera in found}
    found += [
        FoundCamera(TITLES[kind] if kind else name, kind, serial, "" if kind else _WRONG_MODEL)
        for kind, name, serial in sdks.femtos
        # Without permission, the SDK sees a camera and not its serial number.
        if serial not in listed and (serial or kind not in kinds)
    ]
    seen = sum(camera.kind == "azure-kinect" for camera in found)
    title = TITLES["azure-kinect"]
    found += [FoundCamera(title, "azure-kinect", "")] * (sdks.kinects - seen)
    return found


def table_of(cameras: Sequence[FoundCamera]) -> Table:
    """Return them as a table."""
    rows = tuple((each.title, each.serial, each.fault or each.source) for each in cameras)
    return Table("", ("camera", "serial", "use it with"), rows)


def first_camera() -> FoundCamera | None:
    """Return the first camera that can be opened, as far as one can see."""
    return next((each for each in found_cameras() if each.kind and not each.fault), None)


@dataclass(frozen=True, slots=True)
class Choice:
    """The camera that `auto` means."""

    kind: CameraKind
    title: str


def choose(serial: str = "") -> Choice | None:
    """Choose a camera for `auto`: the profile's, else the first; None: none is plugged in.

    Raises `UserError` if there is one, but none that can be used.
    """
    return chosen(found_cameras(), serial)


def chosen(found: Sequence[FoundCamera], serial: str = "") -> Choice | None:
    """See `choose`. Pure."""
    ready = [each for each in found if each.kind and not each.fault]
    ready.sort(key=lambda each: each.serial != serial)
    if ready and ready[0].kind:
        first = ready[0]
        return Choice(ready[0].kind, f"{first.title} {first.serial}".strip())
    broken = [each for each in found if each.fault]
    if broken:
        raise UserError(
            f"source: {broken[0].fault}; or choose the virtual camera with --source sim"
        )
    return None


_WRONG_MODEL = (
    "an Orbbec camera is there, but it is of a model without the sensor that halo-service needs: "
    "use a Femto Bolt or a Femto Mega"
)


def _on_usb(camera: UsbCamera, sdks: SdkCameras) -> FoundCamera:
    return FoundCamera(camera.title, camera.kind, camera.serial, _fault(camera, sdks))


def _fault(camera: UsbCamera, sdks: SdkCameras) -> str:
    from halo_service.sources.orbbec.sdk import EXTRA

    what = f"{camera.title} {camera.serial}".strip()
    if camera.kind is None:
        return _WRONG_MODEL
    if camera.kind != "azure-kinect" and not sdks.has_orbbec:
        return f"an Orbbec camera is there ({what}), but the extra is missing: {EXTRA}"
    if camera.kind == "azure-kinect" and not sdks.has_kinect:
        return f"{what} is there, but its SDK exists only for Linux and Windows on x86-64"
    if not camera.may_open:
        return f"{what} is there, but this user may not open it: halo doctor --fix"
    if camera.is_slow:
        return f"{what} is on USB 2: plug it into a USB 3 port, with a USB 3 cable"
    return ""
