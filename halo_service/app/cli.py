"""`halo`: one command with a few verbs. Errors of use are one sentence on stderr and exit 2."""

from __future__ import annotations

import logging
import os
import signal
import sys
from collections.abc import Sequence

from halo_service.app.parser import parse
from halo_service.app.process import use_one_thread_each
from halo_service.errors import UserError

STOPPED = 130
"""Exit code after Ctrl-C or SIGTERM before the work was complete, as a shell's."""


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command; return its exit code."""
    options = parse(sys.argv[1:] if argv is None else list(argv))
    _set_up_logging(logging.DEBUG if options.debug else logging.INFO)
    use_one_thread_each()
    # Until a command handles it, SIGTERM unwinds as Ctrl-C does, so that nothing is left behind.
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    try:
        code = int(options.run(options))
        sys.stdout.flush()
        return code
    except BrokenPipeError:
        # The program that reads our output has ended, as `head` does: that is a normal end.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0
    except UserError as error:
        if options.debug:
            raise
        print(f"halo: {error}", file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        if options.verb == "serve":
            return 0  # a service runs until somebody ends it
        print("\nhalo: stopped before the end; complete results are kept", file=sys.stderr)
        return STOPPED


def _set_up_logging(level: int) -> None:
    """Let our own modules log at this level, and libraries only their warnings."""
    logging.basicConfig(format="halo: %(message)s", stream=sys.stderr)
    for name in ("halo_service", "halo_calibration"):
        logging.getLogger(name).setLevel(level)
    # MediaPipe imports it for drawings that nobody asks for; in a read-only home it warns.
    logging.getLogger("matplotlib").setLevel(logging.ERROR)


if __name__ == "__main__":
    sys.exit(main())
