"""A progress bar is drawn on a terminal and nowhere else."""

from __future__ import annotations

import os
import subprocess
import sys

import pytest

SCRIPT = """
import sys
from halo_service.app.progress import progress
with progress("counting", 2) as bar:
    bar.advance()
    bar.say("half of [it]")
    bar.advance()
print("rich" in sys.modules)
"""


def test_a_pipe_gets_the_words_alone() -> None:
    result = subprocess.run([sys.executable, "-c", SCRIPT], capture_output=True, timeout=60)
    assert result.stderr.decode().splitlines() == ["half of [it]"]
    assert result.stdout.decode().split() == ["False"]  # nothing heavy is imported for no bar


@pytest.mark.skipif(sys.platform == "win32", reason="pseudo terminals are POSIX")
def test_a_terminal_gets_a_bar_and_the_words() -> None:
    ours, theirs = os.openpty()
    environment = {**os.environ, "TERM": "xterm", "COLUMNS": "100"}
    process = subprocess.Popen(
        [sys.executable, "-c", SCRIPT], stdout=subprocess.PIPE, stderr=theirs, env=environment
    )
    os.close(theirs)
    shown = b""
    while True:
        try:
            part = os.read(ours, 4096)
        except OSError:  # Linux reports the end of a pseudo terminal as an error
            break
        if not part:
            break
        shown += part
    os.close(ours)
    printed, _ = process.communicate(timeout=60)
    assert printed.split() == [b"True"]
    assert b"counting" in shown
    assert b"100%" in shown
    assert b"half of [it]" in shown
