"""The `halo-paint` command: looks for what the guest needs before it loads any of it."""

from __future__ import annotations

from collections.abc import Sequence

from halo_client.extras import require_extra

NEEDS = ("numpy", "pygame")


def main(argv: Sequence[str] | None = None) -> int:
    """Run the guest; a missing library is a sentence, and exit code 2."""
    require_extra("halo-paint", "paint", NEEDS)
    from halo_paint.app import main as run

    return run(argv)
