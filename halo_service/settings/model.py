"""All of `halo.toml` as frozen dataclasses; `[osc]` and `[sensing]` live next to their code.

Rule: a setting is defined once. Its type, range, default and description are here or there, and
reading, error sentences and the JSON schema follow from them.
"""

from __future__ import annotations

import platform
import re
from dataclasses import dataclass, field
from typing import Annotated, ClassVar

from annotated_types import Ge, Interval
from pydantic import ConfigDict, Field

from halo_service.outputs.settings import ControlSettings, OscSettings, TuioSettings, ZenohSettings
from halo_service.sensing.settings import SensingSettings
from halo_service.web.settings import PageSettings, WebSettings


def default_node() -> str:
    """Return this machine's name as the protocol allows it: `[a-z0-9_-]{1,32}`."""
    return re.sub(r"[^a-z0-9_-]+", "-", platform.node().lower()).strip("-")[:32] or "halo"


@dataclass(frozen=True, slots=True)
class SourceSettings:
    """`[source]` in halo.toml: where frames come from."""

    name: str = "auto"
    """`auto`: a camera if one is connected, else the virtual camera. Or `camera` (any),
    `azure-kinect`, `femto-bolt` or `femto-mega`, with options such as `,serial=...`;
    `recording:FILE` or `sim[:SCENARIO]`."""
    wait_s: Annotated[float, Ge(0.0)] = 0.0
    """Longest wait for a camera at the start, for a machine that starts faster than its camera;
    only then `auto` chooses the virtual camera."""
    loop: bool = False
    """Start a recording again when it ends."""
    fast: bool = False
    """Read a recording as fast as possible."""


@dataclass(frozen=True, slots=True)
class TrackingSettings:
    """`[tracking]` in halo.toml: how hands are found."""

    model: str = ""
    """Path of a hand landmarker file; empty: the one that `halo` downloads to the user's cache."""
    max_hands: Annotated[int, Interval(ge=1, le=4)] = 2
    """Number of hands to look for; the second costs time even while it is absent."""


@dataclass(frozen=True, slots=True)
class Settings:
    """All of halo.toml."""

    __pydantic_config__: ClassVar[ConfigDict] = ConfigDict(
        extra="forbid", strict=True, allow_inf_nan=False, use_attribute_docstrings=True
    )
    """The sections inherit it."""

    node: Annotated[str, Field(pattern="^[a-z0-9_-]{1,32}$")] = field(default_factory=default_node)
    """Name of this service on the network; default: this machine's name."""
    profile: str = ""
    """Profile to start with: its name, or the path of its folder. Empty: none; the virtual camera
    then uses its own."""
    source: SourceSettings = field(default_factory=SourceSettings)
    osc: OscSettings = field(default_factory=OscSettings)
    tuio: TuioSettings = field(default_factory=TuioSettings)
    zenoh: ZenohSettings = field(default_factory=ZenohSettings)
    web: WebSettings = field(default_factory=WebSettings)
    page: PageSettings = field(default_factory=PageSettings)
    control: ControlSettings = field(default_factory=ControlSettings)
    sensing: SensingSettings = field(default_factory=SensingSettings)
    tracking: TrackingSettings = field(default_factory=TrackingSettings)
