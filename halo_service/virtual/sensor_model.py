"""What is publicly known of the real sensor, one named parameter a fact.

Rule: numbers and their sources; the code that draws each says how. `TRUE` has
them all. `KIND` is a sensor with white noise and little else, for unit tests of what comes after.
"""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class SensorModel:
    """The errors of one device. Lengths in px are pixels of the narrow unbinned mode."""

    noise_box_px: int = 5
    """Depth noise is white noise through a box of so many pixels each way, and white in time. A
    real recording (the one of pyk4a's tests, on a desk and a wall) has correlations of 0.74, 0.56,
    0.37, 0.20 and 0.04 at 1, 2, 3, 4 and 6 px. In pixels of any mode; 1 is white noise."""
    slow_noise_mm: float = 0.53
    """Deviation of slow waves over the image, new in each frame. With them the mean of 24x24 px
    has a deviation of 0.55 mm, as on 15 frames of open-pack/openpack-dataset."""
    flicker: float = 0.0005
    """Chance that any lit pixel reads 0 in a frame. With the two below, about 17.6 % of the pixels
    that were ever valid read 0 at least once in 15 frames (the same frames); chosen."""
    rim_flicker_px: float = 8.7
    """How slowly that chance grows to 1 at the rim of the lit circle; chosen."""
    dark_flicker_counts: float = 20.0
    """How slowly it falls as infrared grows: by e within so many counts; chosen."""
    warm_up_s: float = 900.0
    """A cold device has lost 95 % of its error after three times that: 45 minutes. Published are
    40 to 50 minutes (Toelgyessy 2021)."""
    clock_drift_ppm: float = 390.0
    """How much faster the device's clock runs than the host's (Azure-Kinect-Sensor-SDK #1384)."""
    slow_s_per_minute: float = 1.0
    """For so long in each minute only 15 frames a second arrive (Azure Kinect ROS driver #194)."""
    exposure_ms: float = 12.8
    """From the first of nine pulses to the last, in the narrow unbinned mode: what moves is blurred
    (hardware specification)."""
    edge_width_px: int = 5
    """Width of the band along a silhouette that is interpolated between front and back
    (Azure-Kinect-Sensor-SDK #789: a few pixels)."""
    edge_sigma_px: float = 1.3
    """Blur of depth in that band, one sigma; chosen."""
    edge_loss: float = 0.4
    """Share of that band that reads 0 where the step is above 30 mm; chosen."""
    moving_edge_loss: float = 0.95
    """The same where the edge moves: the device invalidates it (#789)."""
    stray_light: float = 1.0
    """Times the stray light next to raised things: 3 % of the height at 10 px nearer (frames of
    augcog/OpenARK_test; a SoftKinetic of 320x240, taken over pixel by pixel)."""
    illuminator_mm: float = 20.0
    """From the lens to the illuminator, to the right: raised things have a shadow on their left
    (OrbbecSDK #114, OrbbecSDK_v2 #145). The distance is chosen."""
    shadow_light: float = 0.12
    """Share of the infrared that still reaches a shadow, by way of other surfaces; chosen."""
    shadow_late_mm: float = 6.0
    """How much too far a shadow reads in the mean: only late light reaches it; chosen."""
    shadow_loss: float = 0.4
    """Share of a shadow that reads 0; chosen."""
    material_times: float = 1.0
    """Share of a material's own offset that is drawn (red brick: 10 mm too far, #1570)."""
    dark_offset_mm: float = 10.0
    """How much too far black reads half an image height off the axis (#1570: up to 10 mm); it
    grows with the square of the distance from the axis, chosen."""
    skin_times: float = 1.0
    """Share of the user's `skin_offset_mm` that is drawn (Azure-Kinect-Sensor-SDK #1341)."""


TRUE = SensorModel()
KIND = SensorModel(
    noise_box_px=1,
    slow_noise_mm=0.0,
    flicker=0.0,
    rim_flicker_px=0.0,
    dark_flicker_counts=0.0,
    warm_up_s=600.0,
    clock_drift_ppm=0.0,
    slow_s_per_minute=0.0,
    exposure_ms=0.0,
    edge_width_px=3,
    edge_sigma_px=0.8,
    edge_loss=0.7,
    moving_edge_loss=0.7,
    stray_light=0.0,
    illuminator_mm=0.0,
    material_times=0.0,
    dark_offset_mm=0.0,
    skin_times=0.22,
)
SENSORS = {"true": TRUE, "kind": KIND}
