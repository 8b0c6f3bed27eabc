"""`halo doctor`: check what is missing, and name the remedy."""

from __future__ import annotations

import importlib
import importlib.util
import os
import socket
import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

from halo_calibration.base_model import VIRTUAL, pilot_path
from halo_protocol.osc import padded
from halo_service.app.calibration_ui.calibrate import missing
from halo_service.app.cameras.found import found_cameras
from halo_service.app.service.commands import LEAST_STATUS, STATUS
from halo_service.errors import UserError
from halo_service.evaluation.report.table import Table
from halo_service.files import from_home
from halo_service.profile.store import load, profile_path, profiles_path
from halo_service.settings import Settings
from halo_service.sources.camera_name import TITLES, kind_of
from halo_service.sources.headless import without_display
from halo_service.sources.orbbec.sdk import EXTRA

ANSWER_S = 1.0
"""Time in which a running service answers."""


@dataclass(frozen=True, slots=True)
class Finding:
    """The result of one check."""

    what: str
    good: bool
    state: str
    remedy: str = ""
    optional: bool = False
    """The service also works without it."""


def examine(settings: Settings) -> list[Finding]:
    """Run all checks; they change and download nothing."""
    checks: tuple[Callable[[Settings], Finding], ...] = (
        _packages,
        _sdk,
        _camera,
        _display,
        _model,
        _profile,
        _base,
        control_port,
        _zenoh,
    )
    return [_checked(check, settings) for check in checks]


def _checked(check: Callable[[Settings], Finding], settings: Settings) -> Finding:
    """Run a check; what prevents it is its finding."""
    try:
        return check(settings)
    except UserError as error:
        return Finding(check.__name__.strip("_"), False, str(error))


class Marks(NamedTuple):
    """Words for a finding that is good, that limits nothing needed, and that is bad."""

    good: str
    optional: str
    bad: str


PARTS = Marks("ok", "none", "MISSING")
"""Of what is installed and plugged in."""
NETWORK = Marks("ok", "note", "fail")


def format_finding(finding: Finding, marks: Marks = PARTS) -> str:
    """Return a finding as one line."""
    mark, what, state, remedy = _cells(finding, marks)
    return f"{mark:7} {what}: {state}" + (f"; {remedy}" if remedy else "")


def table_of(findings: list[Finding], marks: Marks = PARTS) -> Table:
    """Return the findings as a table."""
    rows = tuple(_cells(each, marks) for each in findings)
    return Table("", ("", "check", "state", "remedy"), rows)


def _cells(finding: Finding, marks: Marks) -> tuple[str, str, str, str]:
    mark = marks.good if finding.good else marks.optional if finding.optional else marks.bad
    return mark, finding.what, finding.state, "" if finding.good else finding.remedy


def _packages(settings: Settings) -> Finding:
    del settings
    names = ("numpy", "cv2", "mediapipe", "sklearn", "av", "zenoh")
    missing = [name for name in names if importlib.util.find_spec(name) is None]
    if missing:
        return Finding("packages", False, f"{', '.join(missing)} not installed", "run 'uv sync'")
    for name in names:
        try:
            importlib.import_module(name)
        except Exception as error:  # whatever a broken package raises is the finding
            reason = f"{name} cannot be loaded ({error})"
            return Finding("packages", False, reason, "run 'uv sync --reinstall'")
    return Finding("packages", True, "all installed")


def _sdk(settings: Settings) -> Finding:
    kind = kind_of(settings.source.name)
    found = {
        "Azure Kinect": importlib.util.find_spec("pyk4a") is not None,
        "Femto": importlib.util.find_spec("pyorbbecsdk") is not None,
    }
    installed = [name for name, there in found.items() if there]
    if kind == "azure-kinect" and not found["Azure Kinect"]:
        return Finding(
            "camera SDK",
            False,
            "the SDK of the Azure Kinect is not installed",
            "it exists only for Linux and Windows on x86-64; on other systems use a Femto, a "
            "recording or --source sim",
        )
    if kind in ("femto-bolt", "femto-mega") and not found["Femto"]:
        return Finding("camera SDK", False, "the SDK of Orbbec is not installed", f"run '{EXTRA}'")
    if not installed:
        return Finding("camera SDK", False, "none installed", f"run '{EXTRA}'", optional=True)
    return Finding("camera SDK", True, f"installed for {' and '.join(installed)}")


def _camera(settings: Settings) -> Finding:
    name = settings.source.name
    if name.startswith(("sim", "recording:")):
        return Finding("camera", True, f"not needed: the source is {name}")
    kind = kind_of(name)
    cameras = [each for each in found_cameras() if kind in (None, each.kind)]
    ready = [str(each) for each in cameras if not each.fault]
    if ready:
        return Finding("camera", True, "; ".join(ready))
    if cameras:
        return Finding("camera", False, cameras[0].fault)
    what = TITLES[kind] if kind else "camera"
    return Finding(
        "camera",
        False,
        f"no {what} is plugged in",
        "plug it into a USB 3 port and its power supply; until then --source sim works",
        optional=name == "auto",
    )


def _display(settings: Settings) -> Finding:
    kind = kind_of(settings.source.name)
    if not without_display(sys.platform, os.environ):
        return Finding("display", True, "there is one for the depth engine")
    return Finding(
        "display",
        False,
        "DISPLAY is not set, and the depth engine of an Azure Kinect or a Femto Bolt needs it",
        "set DISPLAY=:0 on a machine with a screen, or start 'xvfb-run -a halo serve ...'",
        optional=kind not in ("azure-kinect", "femto-bolt"),
    )


def _model(settings: Settings) -> Finding:
    from halo_service.hand_tracking.model import model_path

    path = from_home(settings.tracking.model) if settings.tracking.model else model_path()
    if not path.is_file():
        return Finding(
            "hand model",
            False,
            f"{path} not found",
            "correct 'model' in [tracking] of the settings file"
            if settings.tracking.model
            else "the first 'halo serve' downloads it (35 MB), or run "
            "'python -m halo_service.hand_tracking.model'",
        )
    return _loaded(path)


def _loaded(path: Path) -> Finding:
    """Load the model: it needs libraries of the system."""
    try:
        from halo_service.hand_tracking.hands import HandTracker

        HandTracker(path).close()
    except UserError as error:
        return Finding("hand model", False, str(error))
    except ImportError as error:
        return Finding(
            "hand model", False, f"mediapipe cannot be loaded ({error})", "run 'uv sync'"
        )
    return Finding("hand model", True, str(path))


def _profile(settings: Settings) -> Finding:
    if not settings.profile:
        return Finding(
            "profile",
            False,
            f"none chosen; profiles are in {profiles_path()}",
            "run 'halo calibrate --profile desk', then use --profile desk",
            optional=True,
        )
    try:
        profile = load(profile_path(settings.profile))
    except UserError as error:
        return Finding("profile", False, str(error))
    left = missing(profile)
    if left:
        return Finding(
            "profile",
            False,
            f"'{profile.name}' lacks {', '.join(left)}",
            f"run 'halo calibrate --profile {settings.profile}'",
        )
    not_good = [name for name, record in profile.steps.items() if record.quality != "good"]
    quality = f"; {', '.join(not_good)} only fair" if not_good else ""
    return Finding("profile", True, f"'{profile.name}', revision {profile.revision}{quality}")


def _base(settings: Settings) -> Finding:
    serial = None
    if settings.profile:
        try:
            serial = load(profile_path(settings.profile)).camera.serial
        except UserError:
            return Finding("base model", True, "checked when a profile is chosen")
    if serial is None:
        return Finding("base model", True, "checked when a profile is chosen")
    if pilot_path(serial).is_file():
        return Finding("base model", True, str(pilot_path(serial)))
    if serial.startswith("VIRTUAL"):
        return Finding("base model", VIRTUAL.is_file(), "that of the virtual camera")
    return Finding(
        "base model",
        False,
        f"none for camera {serial}; only the finger pitch of the wedge is corrected",
        "make one with 'halo calibrate pilot'",
        optional=True,
    )


def control_port(settings: Settings) -> Finding:
    """Check who has the control port."""
    where = f"{settings.control.host}:{settings.control.port}"
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        try:
            probe.bind((settings.control.host, settings.control.port))
        except OSError as error:
            if _is_service(settings.control.host, settings.control.port):
                return Finding("control port", True, f"a halo service runs at {where}")
            return Finding(
                "control port",
                False,
                f"{where} is in use ({error.strerror})",
                "another program has it, so a service uses a free one; or set --control-port",
                optional=True,
            )
    return Finding("control port", True, f"{where} is free")


def _is_service(host: str, port: int) -> bool:
    """Ask a port for the status of a service; false if it does not answer in time."""
    request = padded(STATUS) + padded(",s") + padded("." * LEAST_STATUS)
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    with socket.socket(family, socket.SOCK_DGRAM) as asker:
        asker.settimeout(ANSWER_S)
        try:
            asker.connect((host, port))
            asker.send(request)
            return asker.recv(4096).startswith(padded(STATUS))
        except OSError:
            return False


def _zenoh(settings: Settings) -> Finding:
    if not settings.zenoh.enabled:
        return Finding("zenoh", True, "switched off")
    for endpoint in settings.zenoh.connect:
        protocol, _, address = endpoint.partition("/")
        host, _, port = address.rpartition(":")
        if protocol != "tcp" or not port.isdigit():
            continue
        try:
            socket.create_connection((host.strip("[]"), int(port)), timeout=2.0).close()
        except OSError as error:
            return Finding(
                "zenoh",
                False,
                f"{endpoint} does not answer ({error})",
                "start the router there, or correct 'connect' in [zenoh] of the settings file",
            )
    reached = ", ".join(settings.zenoh.connect) or "no router configured, none needed"
    return Finding("zenoh", True, reached)
