"""Frames in, touches out: the paper's pipeline, a stage a file, told in order by `step`.

Rule: pure functions on values. Nothing here reads a clock, a file or a socket, so a recording
replays to the same bytes.
"""

from halo_service.sensing.settings import SensingSettings
from halo_service.sensing.step import DEFAULT_SURFACE, State, adopt, clear, start, step

__all__ = ["DEFAULT_SURFACE", "SensingSettings", "State", "adopt", "clear", "start", "step"]
