"""Which captures can be sensed."""

from __future__ import annotations

import numpy as np
import pytest

from halo_service.runtime.checks import check_capture
from halo_service.values import BadFrame, Frame

FRAME_US = 33_333


def frame(time_us: int, depth_mm: int = 500) -> Frame:
    depth = np.full((4, 4), depth_mm, np.uint16)
    return Frame(time_us, depth, depth)


@pytest.mark.parametrize(
    ("capture", "last_us", "fault", "missed"),
    [
        (frame(0), None, None, 0),
        (frame(FRAME_US), 0, None, 0),
        (frame(0), 0, "time went back", 0),
        (frame(-5), 0, "time went back", 0),
        (frame(3 * FRAME_US), 0, None, 2),
        (frame(5_000_000), 0, "time jumped by 5.0 s", 0),
        (frame(FRAME_US, depth_mm=0), 0, "no pixel has depth", 0),
        (BadFrame(FRAME_US, "no depth came"), 0, "no depth came", 0),
    ],
)
def test_a_capture_is_checked(
    capture: Frame | BadFrame, last_us: int | None, fault: str | None, missed: int
) -> None:
    check = check_capture(capture, last_us, 30)
    assert check.missed == missed
    if fault is None:
        assert check.fault is None
    else:
        assert check.fault is not None
        assert check.fault.startswith(fault)
