"""A small part of what `benchmarks/fuzz.py --count 1000000` sends to service and clients."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

FUZZ = Path(__file__).parents[2] / "benchmarks" / "fuzz.py"


@pytest.mark.slow
def test_random_and_mutated_input_stops_neither_the_service_nor_a_client() -> None:
    done = subprocess.run(
        [sys.executable, str(FUZZ), "--count", "2500"], capture_output=True, text=True, timeout=300
    )
    assert done.returncode == 0, done.stdout + done.stderr
    lines = done.stdout.splitlines()
    assert len(lines) >= 9, done.stdout
    assert all(line.startswith(("ok", "skip")) for line in lines)
