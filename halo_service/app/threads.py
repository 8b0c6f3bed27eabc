"""One thread each for OpenMP and OpenCV.

Rule: call before NumPy, OpenCV or scikit-learn are imported. On two cores their defaults take the
sensing's p99 from 7 to 42 ms while the hand tracker runs beside it.
"""

from __future__ import annotations

import os

VARIABLES = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "OPENCV_FOR_THREADS_NUM")


def hold_to_one() -> None:
    """Set what the user has not set."""
    for variable in VARIABLES:
        os.environ.setdefault(variable, "1")
