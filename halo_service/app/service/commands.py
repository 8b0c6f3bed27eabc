"""What the arguments of control messages mean.

Rule: pure. Node tools send what they have: a button sends 1 and later 0, a slider sends floats.
"""

from __future__ import annotations

import json
import re
from collections.abc import Sequence
from dataclasses import asdict, fields
from pathlib import Path
from typing import NamedTuple

from pydantic import ValidationError

import halo_protocol as wire
from halo_service.errors import UserError
from halo_service.outputs.formats.packing import Template
from halo_service.profile.store import profile_path
from halo_service.sensing import SensingSettings
from halo_service.settings import Settings
from halo_service.settings.file import ADAPTER
from halo_service.validation import sentences

STATUS = "/halo/1/control/status"
LEAST_STATUS = 256
"""Bytes of a request for the status, filled up by its padding: the answer is not larger."""
PROFILE = re.compile(r"[\w-][\w .-]{0,63}")
"""Names of profiles in the user's data folder; a client must not open other paths."""
SETTINGS = tuple(each.name for each in fields(SensingSettings))
"""Settings that can change while the service runs."""


def is_press(arguments: Sequence[wire.Argument]) -> bool:
    """Whether a message triggers its action: any does, but not the release of a button (0)."""
    return not arguments or not isinstance(arguments[0], int | float) or arguments[0] != 0


def profile_folder(arguments: Sequence[wire.Argument]) -> Path:
    """Return the folder of the profile that a message names. Raises `UserError`."""
    match arguments:
        case (str() as name, *_) if PROFILE.fullmatch(name):
            return profile_path(name)
    raise UserError("send the name of a profile, such as desk; 'halo profile list' shows them")


def with_setting(
    settings: SensingSettings, name: str, arguments: Sequence[wire.Argument]
) -> SensingSettings:
    """Return the settings with one changed. Raises `UserError` for a value that is not allowed."""
    if name not in SETTINGS:
        raise UserError(f"unknown setting; choose from: {', '.join(SETTINGS)}")
    match arguments:
        case (bool(), *_) | ():
            raise UserError("send the value as a number or text")
        case (float() as number, *_):
            value: object = float(f"{number:.7g}")  # a float32 holds 0.2 as 0.200000003
        case (int() | str() as value, *_):
            pass
        case _:
            raise UserError("send the value as a number or text")
    changed = json.dumps({"sensing": {**asdict(settings), name: value}})
    try:
        return ADAPTER.validate_json(changed).sensing
    except ValidationError as error:
        raise UserError("; ".join(sentences(error, Settings))) from error


class Status(NamedTuple):
    """The arguments of the answer to a request for the status."""

    node: str
    session: str
    version: str
    profile: str
    error: str
    """Why the last command failed; empty: it did not."""
    paused: int

    def packed(self) -> bytes:
        """Return the answer, short enough for its question."""
        short = (_ascii(self.profile, 48), _ascii(self.error, 80))
        words = (self.node, self.session, self.version, *short)
        return Template(STATUS, "i", *words).pack(self.paused)[4:]


def _ascii(text: str, longest: int) -> str:
    return text.encode("ascii", "replace").decode()[:longest]
