"""A progress bar is drawn on a terminal and nowhere else."""

from __future__ import annotations

import os
import subprocess
import sys

from tests.terminal import needs_terminal, shown, terminal

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


@needs_terminal
def test_a_terminal_gets_a_bar_and_the_words() -> None:
    environment = {**os.environ, "TERM": "xterm", "COLUMNS": "100"}
    with terminal() as (ours, theirs):
        process = subprocess.Popen(
            [sys.executable, "-c", SCRIPT], stdout=subprocess.PIPE, stderr=theirs, env=environment
        )
        os.close(theirs)
        text = shown(ours)
    printed, _ = process.communicate(timeout=60)
    assert printed.split() == [b"True"]
    assert "counting" in text
    assert "100%" in text
    assert "half of [it]" in text
