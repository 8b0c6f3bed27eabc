"""Change single settings in `halo.toml`; comments, order and all other lines stay.

Rule: a file that the service cannot read is never written, and never replaced.
"""

from __future__ import annotations

import tomllib
from collections.abc import Iterable
from pathlib import Path
from typing import Any, NamedTuple

import tomlkit
from pydantic import ValidationError
from tomlkit.exceptions import TOMLKitError
from tomlkit.items import Table

from halo_service.errors import UserError
from halo_service.files import appearing, read_text
from halo_service.settings.file import DEFAULT_FILE, load, settings_path, validated
from halo_service.settings.model import Settings
from halo_service.validation import sentences


class Change(NamedTuple):
    """One setting."""

    section: str
    """Such as `sensing`; empty: at the top of the file."""
    key: str
    value: Any
    """As JSON has it; None: back to the default, so its line is removed."""


def write(path: Path | None, changes: Iterable[Change]) -> Settings:
    """Write settings; return all of them as they are then.

    `path`: as for `load`; where there is no file, one is made. Raises `UserError` for a value that
    is not allowed, and for a file that cannot be read or written.
    """
    target = settings_path(path) or DEFAULT_FILE
    text = ""
    if target.exists():
        load(target)  # its sentences say what is wrong
        text = read_text(target)
    changed = changed_text(text, changes)
    try:
        settings = validated(tomllib.loads(changed))
    except ValidationError as error:
        raise UserError("\n".join(sentences(error, Settings))) from error
    try:
        with appearing(target) as file:
            file.write(changed.encode())
    except OSError as error:
        raise UserError(f"{target} cannot be written ({error.strerror})") from error
    return settings


def changed_text(text: str, changes: Iterable[Change]) -> str:
    """Return the text of a file with some settings changed. Raises `UserError`."""
    try:
        document = tomlkit.parse(text)
    except TOMLKitError as error:
        raise UserError(f"the settings cannot be read: {error}") from error
    for change in changes:
        table: Any = document
        if change.section:
            if not isinstance(document.get(change.section), Table):
                if change.value is None:
                    continue
                document.append(change.section, tomlkit.table())
            table = document[change.section]
        if change.value is None:
            table.pop(change.key, None)
        else:
            table[change.key] = change.value
    return tomlkit.dumps(document)
