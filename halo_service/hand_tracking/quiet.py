"""What MediaPipe's libraries print on stderr while they start, and import without need.

Rule: only lines known to be harmless are dropped; all others are printed a moment later. The
libraries are C++ and write to the file descriptor, past Python and past their own settings.
"""

from __future__ import annotations

import os
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from types import ModuleType

_STDERR = 2
_PLOTTING = ("matplotlib", "matplotlib.pyplot")
_KNOWN_NOISE = (
    b"Created TensorFlow Lite XNNPACK delegate for CPU",
    b"Logging before InitGoogle() is written to STDERR",
    b"has an unaligned buffer",  # of the detector's network: it is copied once, at the start
    b"Feedback manager requires a model with a single signature inference",
    b"Using NORM_RECT without IMAGE_DIMENSIONS",  # written for developers of graphs
)


@contextmanager
def without_known_noise() -> Iterator[None]:
    """Hold stderr back inside the block, then print what is not known to be noise."""
    sys.stderr.flush()
    terminal = os.dup(_STDERR)
    with tempfile.TemporaryFile() as held:
        os.dup2(held.fileno(), _STDERR)
        try:
            yield
        finally:
            sys.stderr.flush()
            os.dup2(terminal, _STDERR)
            os.close(terminal)
            held.seek(0)
            for line in held:
                if not any(noise in line for noise in _KNOWN_NOISE):
                    os.write(_STDERR, line)


@contextmanager
def without_plotting() -> Iterator[None]:
    """Let MediaPipe be imported without matplotlib, which is most of the import's time.

    One of its modules imports it, for a function that draws landmarks; this project calls none.
    Afterwards matplotlib can be imported as usual.
    """
    if _PLOTTING[0] in sys.modules:
        yield
        return
    empty = {name: ModuleType(name) for name in _PLOTTING}
    sys.modules.update(empty)
    try:
        yield
    finally:
        for name, module in empty.items():
            if sys.modules.get(name) is module:
                del sys.modules[name]
