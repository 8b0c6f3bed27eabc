"""The guest that the client's README shows is a whole program, and it plays."""

import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any


def test_the_guest_in_the_readme_runs(
    udp_service: Callable[..., Any],
    free_port: int,
    repeat: Callable[[Callable[[], object]], None],
    tmp_path: Path,
) -> None:
    readme = Path(__file__).parents[2] / "clients" / "python" / "README.md"
    program = readme.read_text().partition("```python\n")[2].partition("```")[0]
    assert len(program.splitlines()) <= 16
    guest = tmp_path / "guest.py"
    guest.write_text(program.replace("127.0.0.1:9000", f"127.0.0.1:{free_port}"))
    service = udp_service(free_port)
    with subprocess.Popen([sys.executable, str(guest)], stdout=subprocess.PIPE, text=True) as run:
        assert run.stdout is not None
        try:
            assert "nobody plays" in run.stdout.readline()
            repeat(service.tap)
            wanted = {"tom: 210 mm/s, 12 ms ago", "finger 0 is 4.5 mm above"}
            deadline = time.monotonic() + 10
            while wanted and time.monotonic() < deadline:
                wanted -= {run.stdout.readline().strip()}
            assert not wanted
        finally:
            run.terminate()
