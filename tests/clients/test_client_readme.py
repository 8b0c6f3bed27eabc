"""The programs in the READMEs are complete and run."""

import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

CLIENTS = Path(__file__).parents[2] / "clients"


@pytest.mark.parametrize(
    ("readme", "lines"),
    [
        ("python/README.md", {"tom: 210 mm/s, 12 ms ago", "finger 0 is 4.5 mm above"}),
        (
            "README.md",
            {"finger 1 down", "finger 1 " + "#" * 12, "finger 1 up", "finger 1 is 4.5 mm above"},
        ),
    ],
)
def test_the_program_in_the_readme_runs(
    readme: str,
    lines: set[str],
    udp_service: Callable[..., Any],
    free_port: int,
    repeat: Callable[[Callable[[], object]], None],
    tmp_path: Path,
) -> None:
    program = (CLIENTS / readme).read_text().partition("```python\n")[2].partition("```")[0]
    assert len(program.splitlines()) <= 20
    example = tmp_path / "example.py"
    example.write_text(program.replace("127.0.0.1:4256", f"127.0.0.1:{free_port}"))
    service = udp_service(free_port)
    with subprocess.Popen([sys.executable, str(example)], stdout=subprocess.PIPE, text=True) as run:
        assert run.stdout is not None
        try:
            assert "no frames" in run.stdout.readline()
            repeat(service.tap)
            missing = set(lines)
            deadline = time.monotonic() + 10
            while missing and time.monotonic() < deadline:
                missing -= {run.stdout.readline().strip()}
            assert not missing
        finally:
            run.terminate()
