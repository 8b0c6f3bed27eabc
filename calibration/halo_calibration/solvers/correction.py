"""From sweeps to a correction: the paper's regressor, evaluated once on a grid (4.3.4). Pure.

A base model knows from pilots how the halo changes with place, pitch and yaw; the boosting then
goes on from its prediction on the user's own samples. Signals are relative throughout, so that
one finger's base serves another's.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from threadpoolctl import threadpool_limits

from halo_calibration.solvers.dents import by_pitch, by_place, top_by_place
from halo_calibration.solvers.sweep import COLUMNS, READINGS, Samples
from halo_service.geometry.surface import Surface
from halo_service.profile import Correction

MARGIN_MM = 20.0
"""Pointers may leave the surface by as much."""
STEP_MM, STEP_DEG = 15.0, 7.5
"""Of the grid; see `benchmarks/correction.py` for what the interpolation costs."""
PITCH_DEG = (15.0, 75.0)
"""The paper's range (4.3.4)."""
YAW_DEG = (-60.0, 60.0)
"""As far as a hand turns."""
HELD_OUT = 5
"""Every fifth block of samples judges a fit made without it: the paper's 8:2."""
BLOCK = 15
"""Samples in a block: half a second, so that neighbours in time do not test each other."""


@dataclass(frozen=True, slots=True, eq=False)
class Base:
    """A base model's samples, from pilots."""

    name: str
    camera_serial: str
    """The camera they were taken with; used for others only on request."""
    relative: Samples
    """(N, 6): x and y from the surface's middle in mm, pitch and yaw in degrees, signal and dent
    over the pilot's own medians at 45 degrees; nan where the dent was hidden."""


@dataclass(frozen=True, slots=True)
class Reference:
    """Where and how the four states were held: there the correction is 1."""

    x_mm: float
    y_mm: float
    pitch_deg: float
    yaw_deg: float


@dataclass(frozen=True, slots=True)
class Fit:
    """How much a touch's signal varies over the sweep, as a share of its mean."""

    raw: float
    modelled: float
    """After the model's correction, on samples that the fit had not seen."""

    @property
    def helps(self) -> bool:
        """Whether the model predicts more of the halo than it adds errors of its own."""
        return self.modelled < self.raw

    @property
    def corrected(self) -> float:
        """With the correction that `solve_correction` makes: none where the model does not help."""
        return min(self.modelled, self.raw)


class Model:
    """Expected relative signal over x, y, pitch and yaw: the base's prediction, then the user's."""

    def __init__(self, surface: Surface, base: Base | None, samples: Samples | None) -> None:
        """`samples`: (N, 9) the user's sweep, or None before it."""
        self._middle = np.array([surface.width_mm / 2.0, surface.height_mm / 2.0, 0.0, 0.0])
        self._base = None if base is None else boosted(base.relative[:, :4], base.relative[:, 4])
        self._user = None
        if samples is not None and len(samples):
            known = samples[:, 4] / np.median(samples[:, 4]) / self._from_base(samples[:, :4])
            self._user = boosted(samples[:, :4] - self._middle, known)

    def expect(self, where: NDArray[np.float64]) -> NDArray[np.float64]:
        """(N, 4) x, y, pitch, yaw to (N,) relative signal."""
        signal = self._from_base(where)
        if self._user is not None:
            signal = signal * _predicted(self._user, where - self._middle)
        return np.maximum(signal, 0.05)

    def _from_base(self, where: NDArray[np.float64]) -> NDArray[np.float64]:
        if self._base is None:
            return np.ones(len(where))
        return np.maximum(_predicted(self._base, where - self._middle), 0.05)


def solve_correction(
    surface: Surface, base: Base | None, samples: Samples | None, at: Reference
) -> Correction:
    """Evaluate the model on the grid, relative to the reference.

    A model that does not help on samples it has not seen corrects nothing: pilots with another
    sensor, or a halo that hardly changes over the surface.
    """
    helps = samples is None or cross_validate(surface, base, samples).helps
    model = Model(surface, base, samples) if helps else Model(surface, None, None)
    axes = _axes(surface)
    grid = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 4)
    shape = tuple(len(axis) for axis in axes)
    expected = model.expect(grid).reshape(shape)
    here = _Grid(axes, expected).at(np.array([[at.x_mm, at.y_mm, at.pitch_deg, at.yaw_deg]]))[0]
    known = np.empty((0, COLUMNS)) if samples is None else samples
    pilots = np.empty((0, 6)) if base is None else base.relative
    held = at.x_mm, at.y_mm
    places = [by_place(known, axes[0], axes[1], held, column) for column in READINGS]
    tops = top_by_place(known, axes[0], axes[1], held)
    x_mm, y_mm, pitch_deg, yaw_deg = (axis.astype(np.float32) for axis in axes)
    return Correction(
        x_mm,
        y_mm,
        pitch_deg,
        yaw_deg,
        strength=(expected / here).astype(np.float32),
        readings=np.stack([each.strength for each in places]).astype(np.float32),
        deviations=np.stack([each.deviation for each in places]).astype(np.float32),
        dent_by_pitch=by_pitch(pilots, axes[2], at.pitch_deg).astype(np.float32),
        samples=known.astype(np.float32),
        base="" if base is None else base.name,
        tops_mm=None if tops is None else np.stack(tops).astype(np.float32),
    )


def cross_validate(surface: Surface, base: Base | None, samples: Samples) -> Fit:
    """Hold every fifth half second out, fit on the rest, and see what variation is left."""
    block = np.arange(len(samples)) // BLOCK
    out = block % HELD_OUT == HELD_OUT - 1
    model = Model(surface, base, samples[~out])
    held_out = samples[out]
    return Fit(
        _variation(held_out[:, 4]), _variation(held_out[:, 4] / model.expect(held_out[:, :4]))
    )


def relative(samples: Samples, surface: Surface, level: tuple[float, float]) -> Samples:
    """Make a pilot's samples comparable: places from the middle, the rest over the pilot's level.

    `level`: of signal, mm px, and dent, mm.
    """
    middle = np.array([surface.width_mm / 2.0, surface.height_mm / 2.0, 0.0, 0.0, 0.0, 0.0])
    return np.asarray(
        (samples[:, : len(middle)] - middle) / (1.0, 1.0, 1.0, 1.0, *level), dtype=np.float64
    )


class _Grid:
    """The same interpolation as sensing's, for many points."""

    def __init__(self, axes: tuple[NDArray[np.float64], ...], values: NDArray[np.float64]) -> None:
        self._axes, self._values = axes, values

    def at(self, where: NDArray[np.float64]) -> NDArray[np.float64]:
        from scipy.interpolate import RegularGridInterpolator

        ends = [(axis[0], axis[-1]) for axis in self._axes]
        held = np.column_stack(
            [np.clip(column, *end) for column, end in zip(where.T, ends, strict=True)]
        )
        return np.asarray(RegularGridInterpolator(self._axes, self._values)(held))


def _axes(surface: Surface) -> tuple[NDArray[np.float64], ...]:
    def axis(low: float, high: float, step: float) -> NDArray[np.float64]:
        return np.linspace(low, high, max(round((high - low) / step), 1) + 1)

    return (
        axis(-MARGIN_MM, surface.width_mm + MARGIN_MM, STEP_MM),
        axis(-MARGIN_MM, surface.height_mm + MARGIN_MM, STEP_MM),
        axis(*PITCH_DEG, STEP_DEG),
        axis(*YAW_DEG, STEP_DEG),
    )


def boosted(features: NDArray[np.float64], signal: NDArray[np.float64]) -> Any:
    """Fit the paper's regressor; the same samples give the same trees."""
    from sklearn.ensemble import HistGradientBoostingRegressor  # costs a second to import

    regressor = HistGradientBoostingRegressor(
        loss="squared_error",
        learning_rate=0.1,
        max_iter=200,
        max_leaf_nodes=31,
        min_samples_leaf=25,
        max_bins=255,
        early_stopping=False,
        random_state=0,
    )
    with threadpool_limits(1, "openmp"):  # these fits are small: threads would wait, not work
        return regressor.fit(features, signal)


def _predicted(regressor: Any, features: NDArray[np.float64]) -> NDArray[np.float64]:
    with threadpool_limits(1, "openmp"):
        return np.asarray(regressor.predict(features), dtype=np.float64)


def _variation(signal: NDArray[np.float64]) -> float:
    return float(np.std(signal) / np.mean(signal))
