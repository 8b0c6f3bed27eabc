"""The `halo-midi` command: checks for its libraries before it imports them."""

from __future__ import annotations

import sys
from collections.abc import Sequence

from halo_client.extras import require_extra

NEEDS = ("mido", "pygame", "rtmidi")
WITHOUT_PORT, WITHOUT_PORT_NEEDS = {"--render", "--print", "--calibrate"}, ("mido",)
"""Options that need no port."""
WINDOW = {"--window", "--full-screen"}


def main(argv: Sequence[str] | None = None) -> int:
    """Run the client; a missing library gives one sentence and exit code 2."""
    given = sys.argv[1:] if argv is None else list(argv)
    flags = {each.partition("=")[0] for each in given}
    without = flags & WITHOUT_PORT and not flags & WINDOW
    require_extra("halo-midi", "midi", WITHOUT_PORT_NEEDS if without else NEEDS)
    from halo_midi.app import main as run

    return run(argv)
