"""The camera's clock, mapped to the host's Unix time.

Rule: nothing here reads a clock; both times are arguments.
"""

from __future__ import annotations

from collections import deque

_WINDOW = 300
"""Number of frames to compare, 10 s at 30 fps: at least one of them arrived without delay."""
_FITTED_AFTER = 30
"""Frames until the first fit is complete; until then the least delayed frame counts at once."""
_SLEW = 500e-6
"""Correction per time: five times the drift of a bad crystal, and no more than 0.02 ms a frame."""
_JUMP_US = 1_000_000
"""If the clocks differ by more, one was set: time jumps."""


class DeviceClock:
    """Maps a device's timestamps to Unix time.

    A frame reaches the host some milliseconds after its timestamp, sometimes much later, but
    never earlier. So the least delayed of the last frames gives the offset between the clocks. The
    least delay itself stays in it: it cannot be measured here.
    """

    def __init__(self) -> None:
        self._differences: deque[int] = deque(maxlen=_WINDOW)
        """Arrival minus timestamp of the last frames, us."""
        self._offset_us = 0.0
        """Current estimate of Unix time minus device time."""
        self._last_us: tuple[int, int] | None = None
        """The last frame's timestamp and Unix time."""

    def unix_us(self, device_us: int, arrived_us: int) -> int:
        """Return the Unix time of `device_us`, of a frame that reached the host at `arrived_us`.

        It rises while the device time rises, unless a clock was set.
        """
        self._differences.append(arrived_us - device_us)
        error_us = min(self._differences) - self._offset_us
        if self._last_us is None or abs(error_us) > _JUMP_US:
            self._offset_us += error_us
            unix_us = round(device_us + self._offset_us)
        else:
            last_device_us, last_unix_us = self._last_us
            most_us = _SLEW * abs(device_us - last_device_us)
            if len(self._differences) < _FITTED_AFTER:
                most_us = _JUMP_US
            self._offset_us += max(-most_us, min(most_us, error_us))
            unix_us = round(device_us + self._offset_us)
            if device_us > last_device_us:
                unix_us = max(unix_us, last_unix_us + 1)
        self._last_us = device_us, unix_us
        return unix_us
