"""Start of the `halo` program, also `python -m halo_service.app`.

Rule: nothing is imported before Ctrl-C has a handler. The imports take a while, and Ctrl-C in the
middle of them would print where they were.
"""

from __future__ import annotations

import os
import signal
import sys

STOPPED = 130
"""Exit code after Ctrl-C or SIGTERM before the work was complete, as a shell's."""


def main() -> int:
    """Import the command line and run it; return its exit code."""
    # Nothing has begun yet, so nothing needs to be ended. `cli.main` sets a handler of its own.
    signal.signal(signal.SIGINT, lambda *_: os._exit(STOPPED))
    from halo_service.app import cli

    return cli.main()


if __name__ == "__main__":
    sys.exit(main())
