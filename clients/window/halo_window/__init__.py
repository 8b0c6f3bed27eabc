"""A window or projector picture for clients that draw, and their main loop.

Rule: pygame is used here and in the clients' drawing code. A client passes two functions: one
for frames, one for pictures.
"""

import os

# Otherwise pygame prints a greeting to stdout, where clients may write data.
os.environ.setdefault("PYGAME_HIDE_SUPPORT_PROMPT", "1")

from halo_window.loop import listen
from halo_window.options import add_stage_options
from halo_window.stage import Placed, Stage, StageError

__all__ = ["Placed", "Stage", "StageError", "add_stage_options", "listen"]
