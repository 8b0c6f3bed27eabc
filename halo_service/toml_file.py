"""Read a TOML file of the user. Each error is one sentence with the remedy."""

from __future__ import annotations

import json
import re
import tomllib
from collections.abc import Iterator
from pathlib import Path
from typing import Any, TypeVar

from pydantic import TypeAdapter, ValidationError

from halo_service.errors import UserError
from halo_service.files import read_text
from halo_service.validation import sentences

LINE = re.compile(r"at line (\d+)")
CONTROL = re.compile(r"[\x00-\x1f\x7f]")

T = TypeVar("T")


def read(path: Path, what: str, kind: type[T], adapter: TypeAdapter[T]) -> T:
    """Read a file as a dataclass; `what`: the file's purpose, such as `settings`.

    Raises `UserError`, one line per error, for a file that is missing, is not TOML, or has an
    unknown key or a value that is not allowed.
    """
    data = _parsed(path, what)
    errors = list(_control_characters(data))
    if not errors:
        try:
            return validated(data, adapter)
        except ValidationError as error:
            errors = sentences(error, kind)
    raise UserError("\n".join(f"{path}: {each}" for each in errors))


def validated(data: dict[str, Any], adapter: TypeAdapter[T]) -> T:
    """Return the tables of a file as a dataclass. Raises `ValidationError`."""
    # JSON, because there strict mode accepts a list as tuple and a table as dataclass.
    return adapter.validate_json(json.dumps(data, default=lambda date: [str(date)]))


def _parsed(path: Path, what: str) -> dict[str, Any]:
    try:
        text = read_text(path)
    except FileNotFoundError as error:
        raise UserError(
            f"the {what} {path} cannot be read: file not found; check the path"
        ) from error
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or error
        raise UserError(f"the {what} {path} cannot be read: {reason}") from error
    try:
        return tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise UserError(
            f"the {what} {path} cannot be read: {error}{_quotes_hint(text, str(error))}"
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
