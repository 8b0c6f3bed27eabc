"""Settings of the whole process: threads of the libraries, and signals. Standard library alone."""

from __future__ import annotations

import os
import signal
from collections.abc import Callable
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


def stop_on_signals(stop: Callable[[], None]) -> None:
    """Call `stop` on Ctrl-C and SIGTERM."""

    def handle(number: int, where: FrameType | None) -> None:
        stop()

    signal.signal(signal.SIGINT, handle)
    signal.signal(signal.SIGTERM, handle)
