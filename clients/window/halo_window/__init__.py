"""A window or projector picture for clients that draw, and their main loop.

Rule: pygame is used here and in the clients' drawing code. A client passes two functions: one
for frames, one for pictures.
"""

from __future__ import annotations

import os
from typing import TYPE_CHECKING, Any

# Otherwise pygame prints a greeting to stdout, where clients may write data.
os.environ.setdefault("PYGAME_HIDE_SUPPORT_PROMPT", "1")

from halo_window.errors import StageError
from halo_window.loop import listen
from halo_window.options import add_source_option, add_stage_options

if TYPE_CHECKING:
    from halo_window.repaint import Repaint
    from halo_window.stage import Placed, Stage

__all__ = [
    "Placed",
    "Repaint",
    "Stage",
    "StageError",
    "add_source_option",
    "add_stage_options",
    "listen",
]


def __getattr__(name: str) -> Any:
    """Import pygame only for programs that open a window: to write a file needs none."""
    if name in ("Placed", "Stage"):
        from halo_window import stage

        return getattr(stage, name)
    if name == "Repaint":
        from halo_window.repaint import Repaint

        return Repaint
    raise AttributeError(name)
