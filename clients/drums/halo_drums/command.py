"""The `halo-drums` command: checks for its libraries before it imports them."""

from __future__ import annotations

from collections.abc import Sequence

from halo_client.extras import require_extra

NEEDS = ("numpy", "miniaudio", "mido", "pygame")


def main(argv: Sequence[str] | None = None) -> int:
    """Run the client; a missing library gives one sentence and exit code 2."""
    require_extra("halo-drums", "drums", NEEDS)
    from halo_drums.app import main as run

    return run(argv)
