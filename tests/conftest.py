"""What all tests share: strangers' programs are used where installed; in CI none may be missing."""

from __future__ import annotations

import os
import shutil
import signal
import socket
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

# Started in the background by a script, Ctrl-C is ignored, and so it would be by whatever the
# tests start; they ask how a program ends on Ctrl-C.
signal.signal(signal.SIGINT, signal.default_int_handler)

pytest_plugins = ["tests.drawn", "tests.clients.streams"]

REPOSITORY = Path(__file__).parents[1]


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Begin with the files that hold slow tests: the other core waits for what comes last."""
    slow = {item.path for item in items if item.get_closest_marker("slow")}
    items.sort(key=lambda item: item.path not in slow)


@pytest.fixture(scope="session", autouse=True)
def no_profiles_of_the_user(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    """Keep the user's own profiles and base models out of the tests, and theirs out of his."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("XDG_DATA_HOME", str(tmp_path_factory.mktemp("data")))
        yield


@pytest.fixture(scope="session")
def stranger() -> Callable[[str], str]:
    """Return the path of somebody else's program; skip by name where it is not installed."""

    def find(program: str) -> str:
        path = shutil.which(program)
        if path is None:
            if os.environ.get("HALO_CI"):
                pytest.fail(f"{program} is not installed, and .ci/run must install it")
            pytest.skip(f"{program} is not installed")
        return path

    return find


@pytest.fixture(scope="session")
def free_port() -> Callable[[], int]:
    """Return a port that nobody has."""

    def find() -> int:
        with socket.socket() as probe:
            probe.bind(("127.0.0.1", 0))
            return int(probe.getsockname()[1])

    return find


@pytest.fixture(scope="session")
def company_data() -> Path:
    """Return the folder of recordings that nobody here made; skip where it is absent."""
    folder = REPOSITORY.parent / "shared" / "data"
    if not folder.is_dir():
        pytest.skip(f"{folder} is not here")
    return folder
