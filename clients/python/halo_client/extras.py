"""Guests that came without their libraries say so in a sentence.

Rule: it looks for modules and imports none of them.
"""

from __future__ import annotations

import importlib.util
import sys
from collections.abc import Sequence


def require_extra(program: str, extra: str, modules: Sequence[str]) -> None:
    """Return where all modules are installed; else say what brings them, and exit with 2."""
    missing = [name for name in modules if importlib.util.find_spec(name) is None]
    if missing:
        print(  # noqa: T201 - for a program that cannot begin
            f"{program}: {', '.join(missing)} missing; `uv pip install './clients[{extra}]'` "
            "brings what it needs",
            file=sys.stderr,
        )
        raise SystemExit(2)
