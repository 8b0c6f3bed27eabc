"""Options that several commands share, and the settings that result from them."""

from __future__ import annotations

import argparse
import math
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from halo_client import ZenohSource
    from halo_service.settings import Settings

SOURCES = (
    "azure-kinect, femto-bolt, femto-mega (each also with ,serial=...), camera, recording:FILE, "
    "sim[:SCENARIO] or auto (default)"
)


def add_debug(parser: argparse.ArgumentParser) -> None:
    """Add `--debug`."""
    parser.add_argument("--debug", action="store_true", help="print more, and show tracebacks")


def add_config(parser: argparse.ArgumentParser) -> None:
    """Add `--config` and `--debug`."""
    add_debug(parser)
    parser.add_argument(
        "--config", type=Path, metavar="FILE", help="settings file (default: halo.toml)"
    )


def add_profile(parser: argparse.ArgumentParser) -> None:
    """Add `--profile`, `--config` and `--debug`."""
    add_config(parser)
    parser.add_argument(
        "--profile", metavar="P", help="calibration: a path, or a name in your data folder"
    )


def add_source(parser: argparse.ArgumentParser, help_text: str = SOURCES) -> None:
    """Add `--source`."""
    parser.add_argument("--source", metavar="S", help=help_text)


def add_screen(parser: argparse.ArgumentParser) -> None:
    """Add the options that say where pictures are shown."""
    parser.add_argument(
        "--display", type=int, default=0, metavar="N", help="number of the projector's display"
    )
    parser.add_argument("--window", action="store_true", help="use a window, not a whole display")


def seconds(text: str) -> float:
    """Read a length of time, 0 or more, for argparse."""
    value = float(text)
    if not 0.0 <= value < math.inf:
        raise argparse.ArgumentTypeError(f"must be 0 or more seconds, not {text}")
    return value


def found_at(config: Path | None) -> str:
    """Return which settings file is read, for the log."""
    from halo_service.settings import settings_path

    path = settings_path(config)
    return str(path.resolve()) if path else f"defaults (no halo.toml in {Path.cwd()})"


def settings_from(options: argparse.Namespace) -> Settings:
    """Load the settings file; `--profile` and `--source` win over it. Raises `UserError`."""
    from halo_service.settings import load

    settings = load(options.config)
    source = replace(settings.source, name=getattr(options, "source", None) or settings.source.name)
    profile = getattr(options, "profile", None) or settings.profile
    return replace(settings, profile=profile, source=source)


def add_outputs(parser: argparse.ArgumentParser) -> None:
    """Add the options that say where touches are sent by OSC, TUIO and WebSocket."""
    parser.add_argument(
        "--osc",
        action="append",
        metavar="HOST:PORT",
        help="send OSC here instead of 127.0.0.1:4256, e.g. 127.0.0.1:7000/flat,rate=60; may be "
        "repeated",
    )
    parser.add_argument(
        "--tuio",
        action="append",
        metavar="HOST:PORT",
        help="send TUIO 1.1 here, or 2.0 to HOST:PORT/tuio2; may be repeated",
    )
    parser.add_argument("--no-osc", action="store_true", help="send no OSC")
    parser.add_argument("--no-web", action="store_true", help="open no WebSocket server")
    parser.add_argument(
        "--control-port", type=int, metavar="PORT", help="UDP port for control (default: 4257)"
    )


def with_outputs(settings: Settings, options: argparse.Namespace) -> Settings:
    """Return the settings with the options of `add_outputs`, which win."""
    osc, tuio, web, control = settings.osc, settings.tuio, settings.web, settings.control
    port = control.port if options.control_port is None else options.control_port
    return replace(
        settings,
        osc=replace(
            osc,
            enabled=osc.enabled and not options.no_osc,
            destinations=tuple(options.osc or osc.destinations),
        ),
        tuio=replace(tuio, destinations=tuple(options.tuio or tuio.destinations)),
        web=replace(web, enabled=web.enabled and not options.no_web),
        control=replace(control, port=port),
    )


def add_connect(parser: argparse.ArgumentParser, several: str) -> None:
    """Add `--connect`; `several`: what is done with more than one."""
    parser.add_argument(
        "--connect",
        action="append",
        metavar="ENDPOINT",
        help=f"router or service, {several} (default: [zenoh] connect, or tcp/127.0.0.1:7447); may "
        "be repeated",
    )


def zenoh_source(settings: Settings, connect: list[str] | None, mode: str = "") -> ZenohSource:
    """Return where nodes are received; `connect`: of the command line, `mode`: of the session."""
    from halo_client import ZenohSource
    from halo_client.source import DEFAULT_ZENOH_ENDPOINT
    from halo_service.files import from_home

    config = str(from_home(settings.zenoh.config)) if settings.zenoh.config else ""
    default = () if config else (DEFAULT_ZENOH_ENDPOINT,)
    return ZenohSource(
        tuple(connect or settings.zenoh.connect or default), mode=mode, config=config
    )
