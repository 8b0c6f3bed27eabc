"""What is publicly known of the real sensor, next to what frames of the virtual one show.

Rule: each row is a fact, its source, how it is measured on frames, and the range in which it
holds. As in `statements`: where one does not hold, the table says so.
"""

from __future__ import annotations

import functools
from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from halo_service.values import Finger
from halo_service.virtual.bodies import Body, block
from halo_service.virtual.camera import DEPTH_MODE, MODES
from halo_service.virtual.clock import clock_of
from halo_service.virtual.hand import pointing
from halo_service.virtual.noise import DRIFT_MM
from halo_service.virtual.room import HEIGHT_MM, WIDTH_MM, Room
from halo_service.virtual.sensor import Sensor
from halo_service.virtual.sensor_model import TRUE
from halo_service.virtual.skeleton import FingerPose, PosedHand, posed
from halo_service.virtual.statements import Finding, Statement

Depth = NDArray[np.float64]
WINDOW_PX, PATCH_PX = 72, 24
WARM_US = -7_200_000_000
"""A device that was switched on two hours ago."""
REFERENCE = Room(sensor=TRUE)
QUIET = replace(REFERENCE, noise=0.0, camera_height_mm=1000.0)
DIM = replace(REFERENCE, material="suede", camera_height_mm=950.0)
"""As far as the recorded wall, where the deviation is 0.99 mm."""


def check() -> list[Finding]:
    """Measure them all; about 20 s."""
    return [Finding(fact, fact.measure()) for fact in FACTS]


def _reads(
    room: Room, count: int, hands: Sequence[PosedHand] = (), things: Sequence[Body] = ()
) -> Depth:
    """(count, H, W) mm, nan where nothing is measured."""
    sensor = Sensor(room, colour_times=0, started_us=WARM_US)
    frame_us = round(1e6 / sensor.camera.fps)
    frames = [sensor.frame(k * frame_us, hands, things).depth for k in range(count)]
    depth = np.array(frames, dtype=np.float64)
    depth[depth == 0.0] = np.nan
    return depth


def _mean(reads: Depth, axis: int | tuple[int, ...]) -> Depth:
    """Of what is measured; nan where nothing ever is."""
    count = np.count_nonzero(~np.isnan(reads), axis=axis)
    total = np.nansum(reads, axis=axis)
    return np.where(count > 0, total / np.maximum(count, 1), np.nan)


@functools.cache
def _noise() -> Depth:
    """(60, 216, 216) what an empty table's reads differ from their mean; 0 where there is none."""
    reads = _reads(DIM, 60)[:, 180:396, 212:428]
    noise: Depth = np.nan_to_num(reads - _mean(reads, 0))
    return noise


def _correlation(px: int) -> float:
    """Of neighbours along a row, in windows from which a plane is removed."""
    return float(np.mean([_row_product(w, px) for w in _windows()])) / float(
        np.mean([np.mean(w**2) for w in _windows()])
    )


def _row_product(window: Depth, px: int) -> float:
    return float(np.mean(window[:, :-px] * window[:, px:]))


@functools.cache
def _windows() -> list[Depth]:
    rows, columns = np.mgrid[:WINDOW_PX, :WINDOW_PX]
    plane = np.column_stack([np.ones(WINDOW_PX**2), rows.ravel(), columns.ravel()])
    base, _ = np.linalg.qr(plane)
    count = _noise().shape[1] // WINDOW_PX
    cut = _noise().reshape(-1, count, WINDOW_PX, count, WINDOW_PX).swapaxes(2, 3)
    flat = cut.reshape(-1, WINDOW_PX**2)
    return [(w - base @ (base.T @ w)).reshape(WINDOW_PX, WINDOW_PX) for w in flat]


def _in_time() -> float:
    noise = _noise()
    return float(abs(np.mean(noise[1:] * noise[:-1])) / np.mean(noise**2))


def _patch_mm() -> float:
    """Deviation over time of a patch's mean."""
    count = _noise().shape[1] // PATCH_PX
    patches = _noise().reshape(-1, count, PATCH_PX, count, PATCH_PX).mean(axis=(2, 4))
    return float(patches.std(axis=0).mean())


def _flicker() -> float:
    """Share, in %, of the pixels ever valid in 15 frames that read 0 at least once."""
    valid = ~np.isnan(_reads(REFERENCE, 15))
    ever = valid.any(axis=0)
    return 100.0 * float(np.count_nonzero(ever & ~valid.all(axis=0)) / np.count_nonzero(ever))


def _warm_up() -> float:
    """Minutes after which 95 % of what a cold device reads too near has passed."""
    sensor = Sensor(replace(QUIET, camera_height_mm=500.0), colour_times=0)

    def reads(minutes: float) -> float:
        depth = sensor.frame(round(minutes * 6e7)).depth[200:360, 240:400]
        return float(depth[depth > 0].mean())

    warm = reads(1e4)
    minutes = np.arange(1, 91)
    return float(minutes[np.argmax([warm - reads(m) < 0.05 * DRIFT_MM for m in minutes])])


def _hand(room: Room, height_mm: float, **angles: float) -> PosedHand:
    aim = FingerPose(WIDTH_MM / 2.0, HEIGHT_MM / 2.0, height_mm, **angles)
    return posed(room.user, pointing(room.user, room.dominant, aim))


def _skin_mm() -> float:
    """How much too far the back of a hand reads."""
    real = replace(QUIET, camera_height_mm=600.0)
    ideal = replace(real, user=replace(real.user, skin_offset_mm=0.0))
    reads = [_reads(room, 1, [_hand(room, 60.0)])[0] for room in (ideal, real)]
    further = reads[1] - reads[0]
    return float(np.nanmedian(further[further > 2.0]))


def _off_axis(material: str, half_heights: float) -> float:
    """How much too far a material reads, at a distance from the axis in half image heights."""
    at = [_reads(replace(QUIET, material=name), 1)[0] for name in (material, "paper")]
    lens = Sensor(QUIET, colour_times=0).camera.depth
    y, x = round(lens.cy), round(lens.cx - half_heights * lens.height / 2.0)
    box = np.s_[y - 5 : y + 6, x - 5 : x + 6]
    return float(np.nanmean(at[0][box]) - np.nanmean(at[1][box]))


@functools.cache
def _beside_a_block(height_mm: float, camera_mm: float) -> tuple[Depth, Depth, int]:
    """Excess (mm, nan: none) and infrared (share of the empty table's) along the row through the
    axis, and the column of the block's left edge; the block is wider than the image is high."""
    room = replace(QUIET, camera_height_mm=camera_mm)
    sensor = Sensor(room, colour_times=0, started_us=WARM_US)
    lens = sensor.camera.depth
    # Its left side lies in the plane of the axis, so that it hides none of the table.
    left = sensor.surface.from_camera(np.array([[0.0, 0.0, camera_mm]]))[0, 0]
    things = [block(left, -400.0, 500.0, 800.0, height_mm)]
    rows = slice(round(lens.cy) - 10, round(lens.cy) + 11)
    empty, full = ([sensor.frame(k, (), t) for k in range(6)] for t in ((), things))
    depth = np.array([f.depth[rows] for f in full], dtype=np.float64)
    depth[depth == 0.0] = np.nan
    before = np.array([f.depth[rows] for f in empty], dtype=np.float64)
    before[before == 0.0] = np.nan
    excess = _mean(depth - _mean(before, 0), (0, 1))
    infrared = np.mean([f.ir[rows] for f in full], axis=(0, 1)) / np.mean(
        [f.ir[rows] for f in empty], axis=(0, 1)
    )
    return excess, infrared, int(np.ceil(lens.cx))


def _stray_mm(px: int) -> float:
    """How much nearer the table reads next to a block of 300 mm."""
    excess, _, edge = _beside_a_block(300.0, 1000.0)
    return -float(excess[edge - px])


def _under_a_palm_mm() -> float:
    """How much nearer the table reads 10 px next to a block of a palm's size, 60 mm high."""
    room = replace(QUIET, camera_height_mm=500.0)
    x, y, width, long = WIDTH_MM / 2.0 - 85.0, HEIGHT_MM / 2.0 - 50.0, 85.0, 100.0
    before, after = (
        _mean(_reads(room, 6, (), things), 0) for things in ((), [block(x, y, width, long, 60.0)])
    )
    excess = after - before
    lens = Sensor(room, colour_times=0).camera.depth
    row = _mean(excess[round(lens.cy) - 10 : round(lens.cy) + 11], 0)
    edge = int(np.flatnonzero(row < -30.0).max()) + 1
    return -float(row[edge + 9])


def _edge_px() -> float:
    """Pixels between front and back that read something in between."""
    excess, _, edge = _beside_a_block(100.0, 600.0)
    across = excess[edge - 8 : edge + 8]
    return float(np.count_nonzero((across < -20.0) & (across > -95.0)))


def _swept(speed_mm_s: float, mode: str = DEPTH_MODE) -> tuple[Depth, NDArray[np.float64]]:
    """Depth and infrared of a finger 100 mm up that moves to the right, over black."""
    room = replace(QUIET, camera_height_mm=500.0, material="black", mode=mode)
    sensor = Sensor(room, colour_times=0, started_us=WARM_US)
    hand = replace(_hand(room, 100.0), velocity_mm_s=np.array([speed_mm_s, 0.0, 0.0]))
    frame = sensor.frame(1, [hand])
    x, y = sensor.camera.depth.project(sensor.surface.to_camera(hand.joints[Finger.INDEX, 3:4]))[0]
    rows = slice(round(y), round(y) + 15)
    box = rows, slice(round(x) - 30, round(x) + 30)
    return frame.depth[box].astype(np.float64), frame.ir[box].astype(np.float64)


def _blur_px(mode: str = DEPTH_MODE) -> float:
    """How much wider a finger is in the infrared at 1,000 mm/s than at 500."""
    least = 450.0 * MODES[mode].signal
    slow, fast = (
        np.count_nonzero(_swept(speed_mm_s, mode)[1] > least, axis=1).mean()
        for speed_mm_s in (500.0, 1e3)
    )
    return float(fast - slow)


def _lost_px(speed_mm_s: float) -> float:
    """Pixels a row that read 0 at a finger's two edges."""
    return float(np.count_nonzero(_swept(speed_mm_s)[0] == 0.0, axis=1).mean())


def _shadow_px() -> float:
    """Width of the dark strip on the left of a block of 100 mm."""
    _, infrared, edge = _beside_a_block(100.0, 500.0)
    return float(np.count_nonzero(infrared[:edge] < 0.5))


def _drift_ppm() -> float:
    clock = clock_of(REFERENCE, "idle")
    return (clock.device_us(1e4) - clock.start_us) / 1e4 - 1e6


def _missing() -> float:
    """Frames a minute that the rate drops cost."""
    clock = clock_of(REFERENCE, "idle")
    return sum(clock.skips(index) for index in range(round(60 * clock.fps)))


def _bolt_fps(extreme: Callable[[Sequence[float]], float]) -> float:
    rooms = (replace(REFERENCE, seed=seed, device="bolt") for seed in range(40))
    return extreme([clock_of(room, "idle").fps for room in rooms])


def _bolt_starts_s(extreme: Callable[[Sequence[float]], float]) -> float:
    rooms = (replace(REFERENCE, seed=seed, device="bolt") for seed in range(40))
    return extreme([clock_of(room, "idle").start_us / 1e6 for room in rooms])


INFINITE = float("inf")
RECORDING = "public recordings: a desk and a wall, open-pack/openpack-dataset"
SOFTKINETIC = "frames of augcog/OpenARK_test"
PUBLISHED_CORRELATION = {1: 0.74, 2: 0.56, 3: 0.37, 4: 0.20, 6: 0.04}
PUBLISHED_STRAY_MM = {5: 16.0, 10: 9.0, 18: 4.0}

FACTS = (
    Statement(
        "depth noise of the recorded wall",
        RECORDING,
        lambda: float(np.sqrt(np.mean([np.mean(w**2) for w in _windows()]))),
        "mm",
        0.9,
        1.1,
    ),
    *(
        Statement(
            f"correlation of the noise at {px} px",
            RECORDING,
            functools.partial(_correlation, px),
            "",
            value - 0.03,
            value + 0.03,
        )
        for px, value in PUBLISHED_CORRELATION.items()
    ),
    Statement("the noise is white in time: correlation", RECORDING, _in_time, "", 0.0, 0.03),
    Statement("deviation of the mean of 24x24 px", RECORDING, _patch_mm, "mm", 0.5, 0.6),
    Statement(
        "pixels that read 0 at least once in 15 frames", RECORDING, _flicker, "%", 16.6, 18.6
    ),
    Statement(
        "a device is warm (95 %) after 40 to 50 minutes",
        "Toelgyessy 2021",
        _warm_up,
        "min",
        40.0,
        50.0,
    ),
    Statement("skin of a middling user reads too far", "SDK #1341", _skin_mm, "mm", 8.0, 10.0),
    Statement(
        "red brick reads too far",
        "SDK #1570",
        lambda: _off_axis("brick", 0.0),
        "mm",
        9.0,
        11.0,
    ),
    Statement(
        "black reads too far at the image's edge",
        "SDK #1570",
        lambda: _off_axis("black", 0.95),
        "mm",
        8.0,
        10.5,
    ),
    Statement(
        "black reads right in the middle",
        "SDK #1570",
        lambda: _off_axis("black", 0.0),
        "mm",
        -0.5,
        0.5,
    ),
    *(
        Statement(
            f"stray light, {px} px next to 300 mm",
            SOFTKINETIC,
            functools.partial(_stray_mm, px),
            "mm",
            0.85 * value,
            1.15 * value,
        )
        for px, value in PUBLISHED_STRAY_MM.items()
    ),
    Statement(
        "stray light, 10 px next to a palm's size 60 mm up",
        SOFTKINETIC,
        _under_a_palm_mm,
        "mm",
        1.0,
        2.0,
    ),
    Statement("edges are interpolated over a few pixels", "SDK #789", _edge_px, "px", 2.0, 5.0),
    Statement(
        "moving edges are invalidated: lost at 1 m/s, of those lost at rest",
        "SDK #789",
        lambda: _lost_px(1e3) / _lost_px(0.0),
        "times",
        2.0,
        INFINITE,
    ),
    Statement(
        "12.8 ms of exposure: wider by 500 mm/s",
        "hardware specification",
        _blur_px,
        "px",
        5.0,
        7.0,
    ),
    Statement(
        "20.3 ms of exposure, wide unbinned: wider by 500 mm/s",
        "hardware specification",
        functools.partial(_blur_px, "WFOV_UNBINNED"),
        "px",
        8.0,
        11.0,
    ),
    Statement(
        "the illuminator's shadow next to 100 mm",
        "OrbbecSDK #114, OrbbecSDK_v2 #145",
        _shadow_px,
        "px",
        3.0,
        7.0,
    ),
    Statement("the device's clock drifts", "SDK #1384", _drift_ppm, "ppm", 389.0, 391.0),
    Statement(
        "15 frames a second for a second each minute: lost",
        "ROS driver #194",
        _missing,
        "frames",
        14.0,
        16.0,
    ),
    Statement("a Bolt's slowest rate", "OrbbecSDK #49", lambda: _bolt_fps(min), "Hz", 30.03, 30.06),
    Statement("a Bolt's fastest rate", "OrbbecSDK #49", lambda: _bolt_fps(max), "Hz", 30.11, 30.14),
    Statement(
        "a Bolt's earliest first timestamp",
        "OrbbecSDK-K4A-Wrapper #94",
        lambda: _bolt_starts_s(min) / 60.0,
        "min",
        1.0,
        60.0,
    ),
    Statement(
        "a Bolt's latest first timestamp",
        "OrbbecSDK-K4A-Wrapper #94",
        lambda: _bolt_starts_s(max) / 3.156e7,
        "years",
        50.0,
        56.0,
    ),
)
"""`SDK` is the Azure-Kinect-Sensor-SDK."""
