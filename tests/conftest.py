"""Fixtures of all tests. External programs are optional on a desk and required in CI."""

from __future__ import annotations

import os
import shutil
import signal
import sys
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import platformdirs
import pytest

if sys.dont_write_bytecode:
    # Without compiled files, each program that a test starts compiles its packages again, for
    # seconds. Keep them, but outside the folders of the environment and of the repository.
    sys.dont_write_bytecode = False
    sys.pycache_prefix = str(platformdirs.user_cache_path("halo-service") / "compiled")
    os.environ["PYTHONPYCACHEPREFIX"] = sys.pycache_prefix
    os.environ.pop("PYTHONDONTWRITEBYTECODE", None)

from halo_service.app.process import use_one_thread_each
from tests import ports

# As the `halo` command does, and before NumPy is imported. pytest already uses each core: more
# threads make the rendering cost 30 % more.
use_one_thread_each()

# A process started in the background by a script ignores Ctrl-C, and so do its children. Some tests
# check how a program ends on Ctrl-C.
signal.signal(signal.SIGINT, signal.default_int_handler)

pytest_plugins = ["tests.drawn", "tests.clients.streams"]

REPOSITORY = Path(__file__).parents[1]
_EXIT_STATUS = pytest.StashKey[int]()
DRAWING = frozenset({"calibration", "hand_tracking", "sensing", "virtual"})
"""Tests in these folders draw images, and take longer than others."""


def pytest_xdist_auto_num_workers() -> int:
    """Two more processes than cores: nearly half of the tests' time is waiting for a clock or for
    another program."""
    return (os.cpu_count() or 1) + 2


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Run slow files first, so that all processes finish at about the same time."""
    slow = {item.path for item in items if item.get_closest_marker("slow")}
    items.sort(key=lambda item: (item.path not in slow, DRAWING.isdisjoint(item.path.parts)))


LINGER_S = 10.0
"""Threads may end so long after the last test."""


def pytest_sessionfinish(session: pytest.Session, exitstatus: int) -> None:
    session.config.stash[_EXIT_STATUS] = int(exitstatus)


def pytest_unconfigure(config: pytest.Config) -> None:
    """End although a failed test left a Zenoh session open: its thread would never end."""
    until_s = time.monotonic() + LINGER_S
    left = [each for each in threading.enumerate() if not each.daemon]
    left.remove(threading.main_thread())
    for thread in left:
        thread.join(max(until_s - time.monotonic(), 0.0))
    names = ", ".join(each.name for each in left if each.is_alive())
    if names:
        print(f"still running after the tests: {names}", file=sys.stderr, flush=True)
        sys.stdout.flush()
        os._exit(config.stash.get(_EXIT_STATUS, 1))


@pytest.fixture(scope="session", autouse=True)
def no_profiles_of_the_user(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    """Use a temporary data folder, so that tests and user do not share profiles."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("XDG_DATA_HOME", str(tmp_path_factory.mktemp("data")))
        yield


@pytest.fixture(scope="session")
def external_program() -> Callable[[str], str]:
    """Return the path of an external program; skip the test if it is not installed."""

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
    """Return a free port."""
    return ports.free_port


@pytest.fixture(scope="session")
def company_data() -> Path:
    """Return the folder with recordings of real devices; skip the test if it is absent."""
    folder = REPOSITORY.parent / "shared" / "data"
    if not folder.is_dir():
        pytest.skip(f"{folder} is not here")
    return folder
