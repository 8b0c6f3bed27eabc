"""Settings of the whole process: threads of the libraries, and signals. Standard library alone."""

from __future__ import annotations

import atexit
import os
import shutil
import signal
import tempfile
from collections.abc import Callable, MutableMapping
from pathlib import Path
from types import FrameType

THREAD_VARIABLES = (
    "OMP_NUM_THREADS",
    "OPENBLAS_NUM_THREADS",
    "MKL_NUM_THREADS",
    "OPENCV_FOR_THREADS_NUM",
)


def use_one_thread_each() -> None:
    """Limit OpenMP and OpenCV to one thread each, unless the user has set another number.

    Call it before NumPy, OpenCV or scikit-learn are imported. On two cores their defaults raise
    the p99 of the sensing from 7 to 42 ms while the hand tracker runs in parallel.
    """
    for variable in THREAD_VARIABLES:
        os.environ.setdefault(variable, "1")


def give_matplotlib_a_folder(environment: MutableMapping[str, str] = os.environ) -> None:
    """Let matplotlib, which MediaPipe imports, use a temporary folder where the home is read-only.

    Otherwise it prints warnings at every start.
    """
    home = Path(environment.get("HOME", "/"))
    if "MPLCONFIGDIR" in environment or os.name != "posix":
        return
    for variable, folder in (("XDG_CONFIG_HOME", ".config"), ("XDG_CACHE_HOME", ".cache")):
        if not _can_create(Path(environment.get(variable) or home / folder) / "matplotlib"):
            environment["MPLCONFIGDIR"] = tempfile.mkdtemp(prefix="halo-matplotlib-")
            atexit.register(shutil.rmtree, environment["MPLCONFIGDIR"], ignore_errors=True)
            return


def _can_create(folder: Path) -> bool:
    existing = next(each for each in (folder, *folder.parents) if each.exists())
    return os.access(existing, os.W_OK)


def endings() -> tuple[int, ...]:
    """Return the signals that ask a program to end: Ctrl-C, SIGTERM, and a terminal that closes.

    Under `nohup`, which ignores the last one, it is left out.
    """
    hangup = getattr(signal, "SIGHUP", None)  # Windows has none
    closes = hangup is not None and signal.getsignal(hangup) is not signal.SIG_IGN
    return (signal.SIGINT, signal.SIGTERM, *([hangup] if hangup and closes else []))


def stop_on_signals(stop: Callable[[], None]) -> None:
    """Call `stop` on each of `endings`."""

    def handle(number: int, where: FrameType | None) -> None:
        stop()

    for number in endings():
        signal.signal(number, handle)
