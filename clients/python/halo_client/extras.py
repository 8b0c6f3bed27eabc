"""Checks that the optional libraries of a client program are installed.

Rule: it looks for modules and imports none.
"""

from __future__ import annotations

import importlib.util
import sys
from collections.abc import Sequence


def require_extra(program: str, extra: str, modules: Sequence[str]) -> None:
    """Return if all modules are installed; else print how to install them, and exit with 2."""
    missing = [name for name in modules if importlib.util.find_spec(name) is None]
    if missing:
        print(  # noqa: T201 - a program that cannot start
            f"{program}: {', '.join(missing)} missing; `uv pip install './clients[{extra}]'` "
            "installs what it needs",
            file=sys.stderr,
        )
        raise SystemExit(2)
