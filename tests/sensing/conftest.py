"""Which cases today's sensing fails from another height or through another lens, and why.

Each is a length in pixels that should be one in mm. A case that passes again fails the run, so
that it is taken off this list.
"""

from __future__ import annotations

import pytest

BACK_TO_THE_TRACKER = "test_a_track_on_the_neighbour_goes_back_to_the_detected_finger"
FAILS = {
    "test_above_the_halo_height_is_read_off_the_fingers_own_depth[350 mm-80.0]": (
        "label_pixels.BREADTH_PX"
    ),
    f"{BACK_TO_THE_TRACKER}[350 mm-that is higher-20.0]": "outline.MIDLINE_PX",
    f"{BACK_TO_THE_TRACKER}[350 mm-that is higher-26.0]": "outline.MIDLINE_PX",
    f"{BACK_TO_THE_TRACKER}[900 mm-that is higher-20.0]": "tracks.BESIDE_PX",
    f"{BACK_TO_THE_TRACKER}[900 mm-as low-20.0]": "tracks.BESIDE_PX",
    f"{BACK_TO_THE_TRACKER}[wide lens-that is higher-20.0]": "tracks.BESIDE_PX",
    f"{BACK_TO_THE_TRACKER}[wide lens-as low-20.0]": "tracks.BESIDE_PX",
    "test_an_uncertain_finger_has_a_lower_confidence[900 mm-the tracker sees it elsewhere]": (
        "association.STRAYED_PX"
    ),
    "test_an_uncertain_finger_has_a_lower_confidence[wide lens-the tracker sees it elsewhere]": (
        "association.STRAYED_PX"
    ),
}


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Mark the cases that fail."""
    for item in items:
        constant = FAILS.get(item.name)
        if constant is not None:
            reason = f"{constant} is in pixels"
            item.add_marker(pytest.mark.xfail(strict=True, reason=reason))
