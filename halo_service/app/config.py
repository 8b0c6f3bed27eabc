"""Settings: `halo.toml`, with the command line on top.

Rule: an unknown key is answered with the known ones.
"""

from __future__ import annotations

import math
import platform
import re
import tomllib
from dataclasses import dataclass, field, fields, is_dataclass
from pathlib import Path
from typing import Any, Literal, get_args, get_origin, get_type_hints

from halo_service.errors import UserError
from halo_service.outputs.control import PORTS
from halo_service.outputs.settings import ControlSettings, OscSettings, ZenohSettings
from halo_service.sensing.settings import SensingSettings

DEFAULT_FILE = Path("halo.toml")
"""Read from the current folder where there is one and `--config` names no other."""


def default_node() -> str:
    """Return this machine's name as the protocol allows it: `[a-z0-9_-]{1,32}`."""
    return re.sub(r"[^a-z0-9_-]+", "-", platform.node().lower()).strip("-")[:32] or "halo"


@dataclass(frozen=True, slots=True)
class SourceSettings:
    """`[source]`"""

    name: str = "auto"
    """`azure-kinect`, `recording:FILE`, `sim[:SCENARIO]` or `auto`."""
    loop: bool = False
    """Start a recording again when it ends."""
    fast: bool = False
    """Play a recording as fast as it goes."""


@dataclass(frozen=True, slots=True)
class TrackingSettings:
    """`[tracking]`"""

    model: str = ""
    """Path of a hand landmarker bundle; empty: made once and kept in the user's cache folder."""
    max_hands: int = 2
    """Hands looked for; the second costs time while it is not there."""


@dataclass(frozen=True, slots=True)
class Settings:
    """All of `halo.toml`."""

    node: str = field(default_factory=default_node)
    """Name of this service on the network, `[a-z0-9_-]{1,32}`."""
    profile: str = ""
    """The calibration: a path if it has a separator, else a name in the user's data folder."""
    source: SourceSettings = field(default_factory=SourceSettings)
    osc: OscSettings = field(default_factory=OscSettings)
    zenoh: ZenohSettings = field(default_factory=ZenohSettings)
    control: ControlSettings = field(default_factory=ControlSettings)
    sensing: SensingSettings = field(default_factory=SensingSettings)
    tracking: TrackingSettings = field(default_factory=TrackingSettings)


@dataclass(frozen=True, slots=True)
class Range:
    """What a number may be, both ends included."""

    least: float
    most: float

    def __str__(self) -> str:
        """Return it in words."""
        if math.isfinite(self.most):
            return f"from {self.least:g} to {self.most:g}"
        return "0 or more" if self.least == 0.0 else "more than 0"


NOT_NEGATIVE = Range(0.0, math.inf)
POSITIVE = Range(math.ulp(0.0), math.inf)
RANGES = {
    "control.port": Range(PORTS[0], PORTS[-1]),
    "sensing.halo_threshold_mm": NOT_NEGATIVE,  # 0: what the calibration measured
    **{
        f"sensing.{each.name}": POSITIVE
        for each in fields(SensingSettings)
        if each.name != "halo_threshold_mm"
    },
    "tracking.max_hands": Range(1, 4),
}
"""Numbers that are not free, as `section.key`; none may be infinite or no number at all."""


def load(path: Path | None) -> Settings:
    """Read a settings file; `None`: `halo.toml` in the current folder, if there is one.

    Raises `UserError` for a file that is missing, is no TOML or says what nobody understands.
    """
    if path is None and not DEFAULT_FILE.exists():
        return Settings()
    path = path or DEFAULT_FILE
    try:
        text = path.read_text(encoding="utf-8")
        data = tomllib.loads(text)
    except (OSError, UnicodeDecodeError, tomllib.TOMLDecodeError) as error:
        raise UserError(
            f"the settings {path} cannot be read ({error}); mend or remove it"
        ) from error
    settings = _table(Settings, data, "")
    assert isinstance(settings, Settings)  # what _table makes of its first argument
    return settings


def _table(kind: type, data: dict[str, Any], where: str) -> Any:
    """Make a settings dataclass of a TOML table, or say what is wrong with it."""
    hints = get_type_hints(kind)
    known = [f.name for f in fields(kind)]
    prefix = f"{where}: " if where else ""
    for key in data:
        if key not in known:
            raise UserError(f"{prefix}unknown key '{key}'; known: {', '.join(known)}")
    return kind(**{key: _value(hints[key], data[key], prefix, key) for key in data})


def _value(kind: Any, value: Any, prefix: str, key: str) -> Any:
    if is_dataclass(kind):
        assert isinstance(kind, type)  # hints name classes, never instances
        if not isinstance(value, dict):
            raise UserError(f"{prefix}'{key}' must be a table: [{key}]")
        return _table(kind, value, key)
    if get_origin(kind) is Literal:
        choices = get_args(kind)
        if value not in choices:
            raise UserError(f"{prefix}'{key}' must be {' or '.join(choices)}, not {value!r}")
        return value
    if get_origin(kind) is tuple:
        inner = get_args(kind)[0]
        if isinstance(value, list) and all(type(each) is inner for each in value):
            return tuple(value)
        raise UserError(f"{prefix}'{key}' must be a list of {_word(inner)}, not {value!r}")
    if kind is float and type(value) is int:
        value = float(value)
    if type(value) is not kind:
        raise UserError(f"{prefix}'{key}' must be {_word(kind)}, not {value!r}")
    if kind in (int, float):
        _check_range(value, prefix, key)
    return value


def _check_range(value: float, prefix: str, key: str) -> None:
    allowed = RANGES.get(f"{prefix.removesuffix(': ')}.{key}")
    if not math.isfinite(value):
        raise UserError(f"{prefix}'{key}' must be {allowed or 'a finite number'}, not {value}")
    if allowed is not None and not allowed.least <= value <= allowed.most:
        raise UserError(f"{prefix}'{key}' must be {allowed}, not {value:g}")


def _word(kind: type) -> str:
    return {str: "text", int: "a whole number", float: "a number", bool: "true or false"}[kind]
