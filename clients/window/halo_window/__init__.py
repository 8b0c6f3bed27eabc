"""A window or the projector for guests that draw, and the loop that feeds them.

Rule: pygame is touched here and in the guests' own drawing. A guest hands in two functions, one
for frames and one for pictures.
"""

import os

# pygame greets on stdout otherwise, where guests may write data.
os.environ.setdefault("PYGAME_HIDE_SUPPORT_PROMPT", "1")

from halo_window.loop import listen
from halo_window.options import add_stage_options
from halo_window.stage import Placed, Stage, StageError

__all__ = ["Placed", "Stage", "StageError", "add_stage_options", "listen"]
