"""Versions of this program and of its Zenoh, as `scene` reports them."""

from __future__ import annotations

from functools import cache
from importlib.metadata import version


@cache
def service_version() -> str:
    """Return the version of halo-service."""
    return version("halo-service")


@cache
def zenoh_version() -> str:
    """Return the version of the installed Zenoh."""
    return version("eclipse-zenoh")
