"""The `halo-lsl` command: checks for its library before it imports it."""

from __future__ import annotations

from collections.abc import Sequence

from halo_client.extras import require_extra

NEEDS = ("pylsl",)


def main(argv: Sequence[str] | None = None) -> int:
    """Run the client; a missing library gives one sentence and exit code 2."""
    require_extra("halo-lsl", "lsl", NEEDS)
    from halo_lsl.app import main as run

    return run(argv)
