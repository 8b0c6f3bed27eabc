"""The program in the README of the client is complete and runs."""

import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any


def test_the_program_in_the_readme_runs(
    udp_service: Callable[..., Any],
    free_port: int,
    repeat: Callable[[Callable[[], object]], None],
    tmp_path: Path,
) -> None:
    readme = Path(__file__).parents[2] / "clients" / "python" / "README.md"
    program = readme.read_text().partition("```python\n")[2].partition("```")[0]
    assert len(program.splitlines()) <= 16
    example = tmp_path / "example.py"
    example.write_text(program.replace("127.0.0.1:9000", f"127.0.0.1:{free_port}"))
    service = udp_service(free_port)
    with subprocess.Popen([sys.executable, str(example)], stdout=subprocess.PIPE, text=True) as run:
        assert run.stdout is not None
        try:
            assert "no frames" in run.stdout.readline()
            repeat(service.tap)
            missing = {"tom: 210 mm/s, 12 ms ago", "finger 0 is 4.5 mm above"}
            deadline = time.monotonic() + 10
            while missing and time.monotonic() < deadline:
                missing -= {run.stdout.readline().strip()}
            assert not missing
        finally:
            run.terminate()
