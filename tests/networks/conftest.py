"""Machines and networks for each test."""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.networks.lab import Lab, unavailable


@pytest.fixture(scope="session")
def namespaces() -> None:
    """Skip the test where there can be no namespaces; in CI there must be."""
    if reason := unavailable():
        if os.environ.get("HALO_CI"):
            pytest.fail(reason)
        pytest.skip(reason)


@pytest.fixture
def lab(tmp_path: Path, namespaces: None) -> Iterator[Lab]:
    """No machine yet."""
    lab = Lab(tmp_path)
    try:
        yield lab
    finally:
        lab.close()
