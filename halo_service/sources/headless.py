"""The depth engine of Azure Kinect and Femto Bolt needs OpenGL, and on Linux OpenGL a display.

Rule: pure. The engine is Microsoft's, and both SDKs carry it: it fails with code 204 where there is
no display (pyorbbecsdk #39). Orbbec's SDK fails in a thread of its own, which ends the whole
program (OrbbecSDK_v2 #22), so the Bolt is not started then. A Femto Mega computes depth itself.
"""

from __future__ import annotations

from collections.abc import Mapping

DISPLAY_REMEDY = (
    "its depth engine needs a display and DISPLAY is not set: log in on this machine's screen and "
    "set DISPLAY=:0, or start a virtual one ('apt install xvfb', then 'xvfb-run -a halo serve ...')"
)


def without_display(platform: str, environment: Mapping[str, str]) -> bool:
    """Say whether OpenGL has no display."""
    return platform == "linux" and not environment.get("DISPLAY")


def is_engine(reason: str) -> bool:
    """Say whether the depth engine failed. `reason`: the SDK's own words."""
    return "depth engine" in reason.lower()
