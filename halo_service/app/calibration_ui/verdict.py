"""What a step found, as sentences with units and good ranges: for the terminal and the page.

Rule: one row per figure; the ranges are those by which the steps judge.
"""

from __future__ import annotations

import re
from typing import NamedTuple

from halo_calibration.solvers.anchor import SIZE_ERROR
from halo_calibration.solvers.background import THRESHOLD_MM, THRESHOLD_SIGMAS
from halo_calibration.solvers.plane import LEAST_MEASURED
from halo_calibration.solvers.surface import PRINT_ERROR
from halo_calibration.solvers.sweep import GOOD_COVERED
from halo_calibration.solvers.touch import GOOD_SIGMAS
from halo_calibration.steps import background, camera, place, sweep
from halo_service.profile import StepRecord

WITHIN_MM = 5.0
"""Bound of a verification for 95 % of the touches: in the paper they are off by 5.5 mm on average
(6.2)."""


class Figure(NamedTuple):
    """How one figure is shown."""

    words: str
    """With the value as `{}`."""
    good: str = ""
    """Its good range; empty: it has none."""


PERCENT = re.compile(r"(?<=\d)%")
QUIET_MM = THRESHOLD_MM[1] / THRESHOLD_SIGMAS
FIGURES = {
    "camera height_mm": Figure(
        "{:.0f} mm above the table", f"{camera.LOWEST_MM:.0f} to {camera.HIGHEST_MM:.0f} mm"
    ),
    "camera tilt_deg": Figure("tilted by {:.0f} degrees", f"up to {camera.STEEP_DEG:.0f} degrees"),
    "camera measured_share": Figure(
        "{:.0%} of the middle is measured", f"from {camera.LEAST_MEASURED:.0%}"
    ),
    "camera infrared": Figure("infrared brightness {:.0f}", f"from {camera.DARK_COUNTS}"),
    "camera saturated_share": Figure("{:.0%} is too bright", f"up to {camera.MOST_SATURATED:.0%}"),
    "background frames": Figure("{:.0f} frames"),
    "background noise_mm": Figure("depth noise {:.1f} mm", f"up to {QUIET_MM:g} mm"),
    "background measured_share": Figure(
        "{:.0%} of the picture is measured", f"from {LEAST_MEASURED:.0%}"
    ),
    "surface residual_mm": Figure(
        "flat within {:.1f} mm", f"below {background.FAIR_RESIDUAL_MM:g} mm"
    ),
    "surface left_out_share": Figure(
        "{:.0%} of the picture is not the table", f"below {background.FAIR_LEFT_OUT:.0%}"
    ),
    "surface distance_mm": Figure("{:.0f} mm below the camera"),
    "surface tilt_deg": Figure("camera tilted by {:.0f} degrees"),
    "surface error_mm": Figure("error {:.1f} mm", f"below {place.GOOD_CORNERS_MM:g} mm"),
    "sheet error_mm": Figure("error {:.1f} mm", f"below {place.GOOD_SHEET_MM:g} mm"),
    "surface error_px": Figure("{:.1f} px"),
    "surface print_scale": Figure(
        "printed at {:.1%} of its size", f"{1 - PRINT_ERROR:.0%} to {1 + PRINT_ERROR:.0%}"
    ),
    "surface width_mm": Figure("{:.0f} mm wide"),
    "surface height_mm": Figure("{:.0f} mm high"),
    "touch separation_sigmas": Figure(
        "the two most similar states differ by {:.1f} times the noise", f"from {GOOD_SIGMAS:g}"
    ),
    **{
        f"touch {state}_mm_px": Figure(f"halo strength at {state} {{:.0f}} mm px")
        for state in ("hover", "subtle", "touch", "pressure", "hard")
    },
    "sweep samples": Figure("{:.0f} frames"),
    "sweep covered_share": Figure("{:.0%} of the surface covered", f"from {GOOD_COVERED:.0%}"),
    "sweep variation_raw": Figure("a touch varies by {:.0%} over the surface"),
    "sweep variation_corrected": Figure(
        "by {:.0%} with the correction", f"below {sweep.FAIR_CORRECTED:.0%}"
    ),
    "projector error_px": Figure(
        "error {:.1f} px",
        f"below {place.GOOD_PX:g} px; by touch below {place.GOOD_CROSSES_MM:g} mm",
    ),
    "projector error_mm": Figure("{:.1f} mm"),
    "projector points": Figure("{:.0f} points"),
    "projector worst_mm": Figure("worst point {:.1f} mm"),
    "projector covered_share": Figure("{:.0%} of the picture lies between them"),
    "anchor error_mm": Figure("error {:.1f} mm", f"below {place.GOOD_ANCHOR_MM:g} mm"),
    "anchor print_scale": Figure(
        "printed at {:.1%} of its size", f"{1 - SIZE_ERROR:.0%} to {1 + SIZE_ERROR:.0%}"
    ),
    "anchor height_mm": Figure("{:.0f} mm above the surface"),
    "anchor tilt_deg": Figure("tilted by {:.0f} degrees"),
    "verify touches": Figure("{:.0f} touches"),
    "verify crossings": Figure("{:.0f} crossings touched"),
    "verify median_mm": Figure("median error {:.1f} mm"),
    "verify p95_mm": Figure("95 % of the touches within {:.1f} mm", f"up to {WITHIN_MM:g} mm"),
    "verify worst_mm": Figure("worst crossing {:.1f} mm"),
}


def step_line(step: str, record: StepRecord) -> str:
    """Return the result of a step in one line."""
    return f"{step}: {record.quality}. {step_sentence(step, record)}"


def step_sentence(step: str, record: StepRecord) -> str:
    """Return what a step measured, and its note."""
    group = "sheet" if "print_scale" in record.figures and step == "surface" else step
    phrases = [_phrase(step, group, *figure) for figure in record.figures.items()]
    figures = ", ".join(phrases)
    note = f" Note: {record.note}." if record.note else ""
    return f"{figures[:1].upper()}{figures[1:]}.{note}" if figures else note.strip()


def _phrase(step: str, group: str, name: str, value: float) -> str:
    figure = FIGURES.get(f"{group} {name}") or FIGURES.get(f"{step} {name}")
    if figure is None:  # of a newer version
        return f"{name} {value:g}"
    good = f" (good: {figure.good})" if figure.good else ""
    return PERCENT.sub(" %", figure.words.format(value) + good)
