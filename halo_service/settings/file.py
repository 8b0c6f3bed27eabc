"""Read `halo.toml`. Each error is one sentence with the remedy."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from pydantic import TypeAdapter

from halo_service import toml_file
from halo_service.settings.model import Settings

DEFAULT_FILE = Path("halo.toml")
"""Read from the current folder where it exists and `--config` names no other."""
ADAPTER = TypeAdapter(Settings)


def settings_path(path: Path | None) -> Path | None:
    """Return the file that `load` reads; None: there is none, so all settings are the defaults."""
    return path or (DEFAULT_FILE if DEFAULT_FILE.exists() else None)


def load(path: Path | None) -> Settings:
    """Read a settings file; `None`: `halo.toml` in the current folder, if it exists.

    Raises `UserError`, one line per error, for a file that is missing, is not TOML, or has an
    unknown key or a value that is not allowed.
    """
    path = settings_path(path)
    return Settings() if path is None else toml_file.read(path, "settings", Settings, ADAPTER)


def validated(data: dict[str, Any]) -> Settings:
    """Return the settings in the tables of a file. Raises `ValidationError`."""
    return toml_file.validated(data, ADAPTER)
