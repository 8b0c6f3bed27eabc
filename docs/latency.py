"""Run `halo bench` and put its output into docs/latency.md.

    uv run python docs/latency.py

Takes some minutes; run it on a machine with nothing else to do.
"""

from __future__ import annotations

import datetime
import os
import platform
import subprocess
import sys
from pathlib import Path

PAGE = Path(__file__).parent / "latency.md"
BEGIN, END = "<!-- measured -->", "<!-- end of measured -->"


def measured(output: str, commit: str) -> str:
    """Return the text between the marks of the page."""
    machine = f"{platform.system()}, {platform.machine()}, {os.cpu_count()} cores"
    when = (
        f"{datetime.date.today()}, commit {commit}, {machine}, Python {platform.python_version()}"
    )
    return f"{BEGIN}\nMeasured {when}:\n\n```\n{output.strip()}\n```\n{END}"


def replaced(page: str, text: str) -> str:
    """Return the page with `text` for its measured part. Raises `ValueError` without marks."""
    begin, end = page.index(BEGIN), page.index(END) + len(END)
    return page[:begin] + text + page[end:]


def _run(*command: str) -> str:
    return subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True).stdout


def main() -> None:
    """Measure, and write the page."""
    output = _run(sys.executable, "-m", "halo_service.app.cli", "bench")
    text = measured(output, _run("git", "rev-parse", "--short", "HEAD").strip())
    PAGE.write_text(replaced(PAGE.read_text(encoding="utf-8"), text), encoding="utf-8")
    sys.stdout.write(f"{PAGE}\n")


if __name__ == "__main__":
    main()
