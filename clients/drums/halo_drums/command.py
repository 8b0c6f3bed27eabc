"""The `halo-drums` command: checks for its libraries before it imports them."""

from __future__ import annotations

import sys
from collections.abc import Sequence

from halo_client.extras import require_extra

NEEDS = ("numpy", "miniaudio", "mido", "pygame")
RENDERING_NEEDS = ("numpy",)
"""To write a sound file needs no window and no device."""


def main(argv: Sequence[str] | None = None) -> int:
    """Run the client; a missing library gives one sentence and exit code 2."""
    given = sys.argv[1:] if argv is None else list(argv)
    flags = {each.partition("=")[0] for each in given}
    rendering = "--render" in flags and "--picture" not in flags
    require_extra("halo-drums", "drums", RENDERING_NEEDS if rendering else NEEDS)
    from halo_drums.app import main as run

    return run(argv)
