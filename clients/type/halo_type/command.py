"""The `halo-type` command: checks for its libraries before it imports them."""

from __future__ import annotations

from collections.abc import Sequence

from halo_client.extras import require_extra

NEEDS = ("numpy", "miniaudio", "pygame")


def main(argv: Sequence[str] | None = None) -> int:
    """Run the client; a missing library gives one sentence and exit code 2."""
    require_extra("halo-type", "type", NEEDS)
    from halo_type.app import main as run

    return run(argv)
