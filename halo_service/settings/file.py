"""Read `halo.toml`. Each error is one sentence with the remedy."""

from __future__ import annotations

import json
import re
import tomllib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from pydantic import TypeAdapter, ValidationError

from halo_service.errors import UserError
from halo_service.files import read_text
from halo_service.settings.model import Settings
from halo_service.validation import sentences

DEFAULT_FILE = Path("halo.toml")
"""Read from the current folder where it exists and `--config` names no other."""
ADAPTER = TypeAdapter(Settings)
LINE = re.compile(r"at line (\d+)")
CONTROL = re.compile(r"[\x00-\x1f\x7f]")


def settings_path(path: Path | None) -> Path | None:
    """Return the file that `load` reads; None: there is none, so all settings are the defaults."""
    return path or (DEFAULT_FILE if DEFAULT_FILE.exists() else None)


def load(path: Path | None) -> Settings:
    """Read a settings file; `None`: `halo.toml` in the current folder, if it exists.

    Raises `UserError`, one line per error, for a file that is missing, is not TOML, or has an
    unknown key or a value that is not allowed.
    """
    path = settings_path(path)
    if path is None:
        return Settings()
    data = _parsed(path)
    errors = list(_control_characters(data))
    if not errors:
        try:
            return validated(data)
        except ValidationError as error:
            errors = sentences(error, Settings)
    raise UserError("\n".join(f"{path}: {each}" for each in errors))


def validated(data: dict[str, Any]) -> Settings:
    """Return the settings in the tables of a file. Raises `ValidationError`."""
    # JSON, because there strict mode accepts a list as tuple and a table as dataclass.
    return ADAPTER.validate_json(json.dumps(data, default=lambda date: [str(date)]))


def _parsed(path: Path) -> dict[str, Any]:
    try:
        text = read_text(path)
    except FileNotFoundError as error:
        raise UserError(
            f"the settings {path} cannot be read: file not found; check the path"
        ) from error
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or error
        raise UserError(f"the settings {path} cannot be read: {reason}") from error
    try:
        return tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise UserError(
            f"the settings {path} cannot be read: {error}{_quotes_hint(text, str(error))}"
        ) from error


def _quotes_hint(text: str, error: str) -> str:
    """Return what to do where the failing line holds a backslash, as Windows paths do."""
    line = LINE.search(error)
    if line is None or "\\" not in text.splitlines()[int(line[1]) - 1]:
        return ""
    return r"; write a path with backslashes in single quotes, such as 'C:\new.mkv'"


def _control_characters(data: dict[str, Any], section: str = "") -> Iterator[str]:
    """Yield a sentence for each text that holds one: TOML reads "C:\\new" as C:, newline, ew."""
    for key, value in data.items():
        if isinstance(value, dict):
            yield from _control_characters(value, f"{key}: ")
        texts = value if isinstance(value, list) else [value]
        for text in texts:
            if isinstance(text, str) and (found := CONTROL.search(text)):
                yield (
                    f"{section}'{key}' holds the control character {found[0]!r}; write a path "
                    rf"with backslashes in single quotes, such as 'C:\new.mkv'"
                )
