"""An evening in short: a whole service, and everything that goes wrong with it.

    uv run python -m benchmarks.soak             an hour
    uv run python -m benchmarks.soak --seconds 600

The camera is drawn (`tests/faults.py`): a finger taps twice a second. One fault after the other is
switched on and off; a client counts what it receives (`soaking/` has the parts). Exit code 1 if a
pointer stays, an error leaves the live loop, memory grows by more than 2 %, or a fault is not
reported or not recovered from in time. Linux only.
"""

from __future__ import annotations

import argparse
import signal
import sys
import tempfile
from contextlib import ExitStack
from pathlib import Path

from benchmarks.soaking.evening import run
from benchmarks.soaking.observer import Observer
from benchmarks.soaking.result import result
from benchmarks.soaking.running import Running
from halo_service.app.process import use_one_thread_each


def main() -> int:
    """Run faults until the time is over; print what was seen."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seconds", type=float, default=3600.0)
    seconds = parser.parse_args().seconds
    use_one_thread_each()  # as the `halo` command does; the processes that are started inherit it
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(1))  # service and router end, too
    with tempfile.TemporaryDirectory() as folder, ExitStack() as stack:
        observer = Observer(Running(Path(folder), stack))
        run(observer, seconds)
        log = (Path(folder) / "service.log").read_text()
        return result(observer.figures, observer.seen, log)


if __name__ == "__main__":
    sys.exit(main())
