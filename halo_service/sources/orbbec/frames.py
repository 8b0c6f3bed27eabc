"""A frame set of Orbbec's SDK to our `Frame`.

Rule: pixels are copied, because the SDK uses its buffers again.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from halo_service.geometry.camera import Lens
from halo_service.host_clock import CLOCK
from halo_service.sources.clock import DeviceClock
from halo_service.values import BadFrame, Frame

_MOST_DELAY_US = 1_000_000
"""Longest time between a frame's arrival and its read; more means another clock."""


def outcome(sdk: Any, frames: Any, lens: Lens, clock: DeviceClock) -> Frame | BadFrame:
    """Turn a frame set into a frame in Unix time, its JPEG untouched."""
    depth, ir, colour = frames.get_depth_frame(), frames.get_ir_frame(), frames.get_color_frame()
    now_us = CLOCK.unix_us()
    if depth is None or ir is None:
        return BadFrame(now_us, f"no {'depth' if depth is None else 'IR'} in this capture")
    depth_mm, infrared = _grey(sdk, depth, lens), _grey(sdk, ir, lens)
    if depth_mm is None or infrared is None:
        return BadFrame(now_us, f"a torn {'depth' if depth_mm is None else 'IR'} image")
    scale = float(depth.get_depth_scale())
    if scale != 1.0:
        depth_mm = np.rint(depth_mm * scale).clip(0, 65535).astype(np.uint16)
    return Frame(time_us(depth, clock, now_us), depth_mm, infrared, _jpeg(sdk, colour))


def time_us(depth: Any, clock: DeviceClock, now_us: int) -> int:
    """Return the Unix time of the exposure; of the arrival if the device gives no time."""
    arrived_us = int(depth.get_system_timestamp_us())
    if not 0 <= now_us - arrived_us <= _MOST_DELAY_US:
        arrived_us = now_us
    device_us = int(depth.get_timestamp_us())
    return clock.unix_us(device_us, arrived_us) if device_us else arrived_us


def _grey(sdk: Any, image: Any, lens: Lens) -> NDArray[np.uint16] | None:
    """(H, W) uint16, or None for another format or size."""
    if image.get_format() != sdk.OBFormat.Y16:
        return None
    data = np.asarray(image.get_data(), dtype=np.uint8)
    if data.size != lens.width * lens.height * 2:
        return None
    return data.view("<u2").reshape(lens.height, lens.width).astype(np.uint16)


def _jpeg(sdk: Any, colour: Any | None) -> bytes | None:
    if colour is None or colour.get_format() != sdk.OBFormat.MJPG:
        return None
    return np.asarray(colour.get_data(), dtype=np.uint8).tobytes() or None
