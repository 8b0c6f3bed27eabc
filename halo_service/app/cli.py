"""`halo`: one command with a few verbs. Errors of use are one sentence on stderr and exit 2."""

from __future__ import annotations

import logging
import os
import signal
import sys
from collections.abc import Sequence

from halo_service.app.__main__ import STOPPED
from halo_service.app.logs import set_up_logging
from halo_service.app.parser import parse
from halo_service.app.process import endings, give_matplotlib_a_folder, use_one_thread_each
from halo_service.errors import UserError


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command; return its exit code."""
    options = parse(sys.argv[1:] if argv is None else list(argv))
    level = logging.DEBUG if options.debug else logging.INFO
    set_up_logging(level, getattr(options, "log_json", False))
    use_one_thread_each()
    give_matplotlib_a_folder()
    try:
        # Until a command handles them, these unwind as Ctrl-C does, so that nothing is left behind.
        for number in endings():
            signal.signal(number, signal.default_int_handler)
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
        print("\nhalo: stopped before the end; complete results are saved", file=sys.stderr)
        return STOPPED


if __name__ == "__main__":
    sys.exit(main())
