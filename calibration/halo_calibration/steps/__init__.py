"""The steps: what was seen becomes a change of the profile.

Rule: no prompts, no frames fetched, no files. Guided and scripted calibration share these.
"""

from halo_calibration.steps.background import background_change, surface_change
from halo_calibration.steps.change import STEPS, Change, Setup, require, rounded
from halo_calibration.steps.sweep import sweep_change, watch_sweep
from halo_calibration.steps.touch import NO_DENTS, NO_HARD, touch_change, watch_hold

__all__ = [
    "NO_DENTS",
    "NO_HARD",
    "STEPS",
    "Change",
    "Setup",
    "background_change",
    "require",
    "rounded",
    "surface_change",
    "sweep_change",
    "touch_change",
    "watch_hold",
    "watch_sweep",
]
