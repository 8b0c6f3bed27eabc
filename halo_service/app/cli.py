"""`halo`: one command with a few verbs. Errors of use are one sentence on stderr and exit 2."""

from __future__ import annotations

import logging
import os
import signal
import sys
from collections.abc import Sequence

from halo_service.app.options import parser
from halo_service.app.threads import hold_to_one
from halo_service.errors import UserError

STOPPED = 130
"""Exit code of what Ctrl-C or SIGTERM ended before it was done, as a shell's."""


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command; return its exit code."""
    arguments = sys.argv[1:] if argv is None else list(argv)
    if arguments[:1] == ["monitor"]:
        from halo_tools.monitor import main as monitor

        return monitor(arguments[1:])
    if arguments[:1] == ["demo"]:
        from halo_service.app.demo import main as demo

        return demo(arguments[1:])
    options = parser().parse_args(arguments)
    _speak(logging.DEBUG if options.debug else logging.INFO)
    hold_to_one()
    # Until a verb listens itself, SIGTERM unwinds as Ctrl-C does, so that nothing is left behind.
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    try:
        code = int(options.run(options))
        sys.stdout.flush()
        return code
    except BrokenPipeError:
        # Who reads what we print has had enough, as `head` does: that is a normal end.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0
    except UserError as error:
        if options.debug:
            raise
        print(f"halo: {error}", file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        if options.verb == "serve":
            return 0  # a service is not done before somebody ends it
        print("\nhalo: stopped before it was done; what is complete is kept", file=sys.stderr)
        return STOPPED


def _speak(level: int) -> None:
    """Let our own modules tell what they do, and libraries no more than their warnings."""
    logging.basicConfig(format="halo: %(message)s", stream=sys.stderr)
    for name in ("halo_service", "halo_calibration"):
        logging.getLogger(name).setLevel(level)


if __name__ == "__main__":
    sys.exit(main())
