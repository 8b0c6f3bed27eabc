"""The empty table, simulated once per process; each file that uses it gets its own copy."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from halo_service.evaluation.study.cache import RecordingCache
from tests.evaluation.study.empty_table import cache_in, store_empty_table


@pytest.fixture(scope="session")
def empty_table(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder with one user's calibration of the empty table."""
    folder = tmp_path_factory.mktemp("empty")
    store_empty_table(folder)
    return folder


@pytest.fixture(scope="module")
def cache(empty_table: Path, tmp_path_factory: pytest.TempPathFactory) -> RecordingCache:
    """Return a cache that holds the empty table."""
    folder = tmp_path_factory.mktemp("recordings")
    shutil.copytree(empty_table, folder, dirs_exist_ok=True)
    return cache_in(folder)
