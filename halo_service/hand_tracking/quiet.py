"""Filter what MediaPipe's libraries print on stderr while they start.

Rule: only lines known to be harmless are dropped; all others are printed a moment later. The
libraries are C++ and write to the file descriptor, past Python and past their own settings.
"""

from __future__ import annotations

import os
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager

_STDERR = 2
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
